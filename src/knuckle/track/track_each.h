// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/pipeline/estimate_each.h"

namespace knuckle {

/// Follows hands through the frames of a source with the pipeline's tracker (`Pipeline::tracker`), and hands
/// over what it finds in the order of the frames, one at a time: hands with ids, angles and skeleton, surest
/// first. Frames are read on all threads, and followed one after another. A frame that cannot be read is a
/// result with a fault; the hands are looked for again in the next one. Ids begin with 1 in each sequence.
///
/// With `options.first` the tracker begins at the start of the sequence that this frame belongs to, so that
/// results are those of a run from the beginning. Throws what `take` or the pipeline throws, Interrupted
/// where the program is asked to end; an Error where the pipeline has no tracker, or the start is not
/// `nearest`: a tracker chooses itself.
void track_each(const FrameSource& source, const Pipeline& pipeline, const RunOptions& options,
                const TakeResult& take);

}  // namespace knuckle
