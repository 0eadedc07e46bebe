// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <torch/types.h>

namespace knuckle {

/// Like tensors of several lists, cut alike into pieces that fit a core's cache. So what is done to a piece,
/// one operation after another, reads and writes main memory once, and pieces are worked on by all threads.
///
/// All lists have tensors of the same shapes in the same order.
class TensorPieces {
 public:
  /// The shapes of the lists to come.
  explicit TensorPieces(const std::vector<torch::Tensor>& like);

  int64_t size() const { return static_cast<int64_t>(pieces_.size()); }
  /// Calls work(index, pieces) for each piece, without gradients, in no order: `pieces` has the piece of each
  /// list, and shares memory with it.
  void for_each(const std::vector<std::vector<torch::Tensor>>& lists,
                const std::function<void(int64_t, std::vector<torch::Tensor>&)>& work) const;

 private:
  struct Piece {
    std::size_t tensor;
    int64_t begin;
    int64_t length;  // 0: the whole tensor as it is
  };

  std::vector<Piece> pieces_;
};

}  // namespace knuckle
