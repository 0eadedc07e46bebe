// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/tensor_pieces.h"

#include <algorithm>

#include <torch/utils.h>

#include "knuckle/core/parallel.h"
#include "knuckle/training/torch_threads.h"

namespace knuckle {
namespace {

constexpr int64_t kNumbersPerPiece = 32768;  // 128 KiB: five lists' pieces fit a cache of 1 MiB

}  // namespace

TensorPieces::TensorPieces(const std::vector<torch::Tensor>& like) {
  for (std::size_t i = 0; i < like.size(); ++i) {
    const int64_t count = like[i].numel();
    if (count <= kNumbersPerPiece || !like[i].is_contiguous() || !like[i].device().is_cpu()) {
      pieces_.push_back({i, 0, 0});
      continue;
    }
    for (int64_t begin = 0; begin < count; begin += kNumbersPerPiece) {
      pieces_.push_back({i, begin, std::min(kNumbersPerPiece, count - begin)});
    }
  }
}

void TensorPieces::for_each(const std::vector<std::vector<torch::Tensor>>& lists,
                            const std::function<void(int64_t, std::vector<torch::Tensor>&)>& work) const {
  parallel_for(size(), [&](int64_t index) {
    use_calling_thread_alone();
    const torch::NoGradGuard no_gradient;
    const Piece& piece = pieces_[static_cast<std::size_t>(index)];
    std::vector<torch::Tensor> pieces;
    for (const std::vector<torch::Tensor>& list : lists) {
      const torch::Tensor whole = list[piece.tensor].detach();
      pieces.push_back(piece.length == 0 ? whole : whole.view(-1).narrow(0, piece.begin, piece.length));
    }
    work(index, pieces);
  });
}

}  // namespace knuckle
