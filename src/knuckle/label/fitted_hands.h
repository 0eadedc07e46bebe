// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "knuckle/data/frame_source.h"
#include "knuckle/label/label_book.h"
#include "knuckle/label/label_fit.h"
#include "knuckle/label/person_bones.h"

namespace knuckle {

/// What the hand model says of the labels of one source: the fits to hands as they stand, and the bones of
/// each person, learned from the verified hands of a sequence. Used by one thread at a time.
class FittedHands {
 public:
  /// Learns the bones from the first verified hands there are, from their landmarks alone: images are not
  /// read, and it takes as long for 10,000 frames as for 100. What the others say, `learn_bones` learns.
  /// Source and book have to live as long. Throws an Error where a frame's label cannot be read.
  FittedHands(const FrameSource& source, const LabelBook& book, const LabelFitOptions& options);

  const LabelFitOptions& options() const { return options_; }
  /// That a frame belongs to. Throws an Error where the source cannot say it.
  int sequence_of(std::int64_t frame) const;

  /// What is known of a hand beside its labels: the person's bones, and the pose of its last fit.
  LabelFitContext context_of(HandKey hand) const;
  /// The hand model fitted to `labels` of a hand, as `fit_labels` does, with what machines saw of it last and
  /// with what is known of it.
  std::optional<LabelFit> fit(HandKey hand, const std::vector<LandmarkLabel>& labels,
                              const Frame& frame) const;
  /// As above, with another context.
  std::optional<LabelFit> fit(HandKey hand, const std::vector<LandmarkLabel>& labels, const Frame& frame,
                              const LabelFitContext& context) const;

  /// The fit to a hand as it stands, fitted now where it is not kept; null where there is none. Valid until
  /// the hand's next one.
  const LabelFit* newest_fit(HandKey hand, const HandHistory& history, const Frame& frame);
  /// Keeps the fit to a revision of a hand. Where it follows from verified neighbours, a share of its doubt
  /// is left, [0, 1].
  void keep(HandKey hand, std::int64_t revision, const LabelFit& fit, double share_of_doubt = 1.0);
  /// The fit to revision `before`, if it is kept, is that to `after` as well: the landmarks are the same.
  void keep_unchanged(HandKey hand, std::int64_t before, std::int64_t after);
  /// The fit that was kept last, whatever its revision; null where there is none.
  const LabelFit* find(HandKey hand) const;

  /// How far the hand's labels may be off, after its last fit [mm].
  double doubt_mm(HandKey hand) const;
  /// Length of its palm, after its last fit; a usual one where there is none [mm].
  double palm_mm(HandKey hand) const;

  /// Learns the person's bones from a hand, anew, or forgets them where it is not verified any more.
  void learn_bones(HandKey hand, const Frame& frame);

 private:
  /// A fit, and of which labels.
  struct KeptFit {
    std::int64_t revision = 0;
    LabelFit fit;
    double doubt_mm = 0.0;
  };

  void learn_first_bones();
  std::vector<ImagePoint> estimates_of(HandKey hand) const;

  const FrameSource& source_;
  const LabelBook& book_;
  LabelFitOptions options_;
  mutable std::map<std::int64_t, int> sequences_;  ///< of frames that were asked for: sources may be slow
  std::map<HandKey, KeptFit> fits_;
  std::map<std::pair<int, HandSide>, PersonBones> bones_;  ///< one per sequence and side
};

}  // namespace knuckle
