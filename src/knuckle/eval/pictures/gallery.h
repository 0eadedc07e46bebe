// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "knuckle/core/options.h"
#include "knuckle/data/frame_source.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/eval/metrics/evaluation.h"
#include "knuckle/eval/metrics/followed_hands.h"

namespace knuckle {

/// One picture of a gallery.
struct GalleryPicture {
  std::string caption;  ///< the method
  std::string note;     ///< its error in this frame, or "missing"; may be empty
  Image<Rgb> picture;
};

/// One frame, seen once a method.
struct GalleryRow {
  std::string caption;            ///< the frame
  bool shows_truth = false;       ///< whether a true skeleton is drawn
  bool shows_difference = false;  ///< whether a fitted surface is held against the depth image
  std::vector<GalleryPicture> pictures;
};

/// What a gallery shows.
struct GalleryOptions {
  int even_frames = 8;        ///< frames spread evenly over the sequence, [0, 1000]
  int worst_frames = 1;       ///< the worst frames of each method, where there is truth, [0, 100]
  int picture_size_px = 300;  ///< of a picture's side, [64, 2000]

  void visit(OptionVisitor& visitor);
};

/// What pictures are made from. A pointer may be null: without a source the skeletons stand on plain ground,
/// without truth (and its evaluation) only the estimates are drawn.
struct GalleryInput {
  const FrameSource* source = nullptr;
  const Truth* truth = nullptr;
  const Evaluation* evaluation = nullptr;
  std::span<const Predictions> methods;
  std::span<const NamedRecords> records = {};  ///< one record per frame of the source each
};

/// How many frames there are to choose from.
std::int64_t frames_to_show(const GalleryInput& input);

/// Pictures of chosen frames, cropped around the hand: true skeleton in one colour, estimated one in another.
/// Without truth the crop follows the estimates, so the whole frame stands before it, with the crop's
/// outline. Each method's records are shown by a picture of its own: the surfaces that were fitted to the
/// hands over the depth image, the skeletons of hands without; and where a surface was fitted, by a second
/// one: its difference to the depth image (surface_picture.h). Frames are read on all threads.
std::vector<GalleryRow> make_gallery(const GalleryInput& input, const GalleryOptions& options = {});

}  // namespace knuckle
