// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "knuckle/data/frame_source.h"
#include "knuckle/label/label_book.h"
#include "knuckle/label/label_fit.h"

namespace knuckle {

/// The landmarks of hands, one per landmark of the book's convention; missing where they are not labelled.
using SmoothedLabels = std::map<HandKey, std::vector<ImagePoint>>;

/// What the labels of a sequence say together. Each landmark's place in space becomes that of a parabola in
/// time, fitted by least squares to its labels at most `reach` frames away, [1, 100] (Savitzky and Golay,
/// 1964): what moves evenly stays as it is, the tremble of clicks and guesses averages out. Near labels count
/// most (a normal distribution with 0.6 of the reach as its deviation), and each as much as what made it can
/// be trusted (`LabelFitOptions`): a click on what is seen, a guess at what is hidden, or a machine. Where
/// three labels are near it is a line; where fewer are, the label stays.
///
/// Of all hands that are at least `least`; only hands of the same sequence and side count for each other.
/// Time is that of the frames, or their numbers where one has none, or times do not rise. Throws an Error
/// where `reach` is out of range or the label of a frame cannot be read.
SmoothedLabels smoothed_labels(const FrameSource& source, const LabelBook& book, LabelState least, int reach,
                               const LabelFitOptions& options = {});

}  // namespace knuckle
