// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/kept_weights.h"

#include <algorithm>

#include <torch/autograd.h>
#include <torch/utils.h>

namespace knuckle {
namespace {

// LibTorch's index_select takes a strided copy a column on the way back: 20 times as long as these loops.

/// Calls work(kept row, kept column or the row's begin, place in the whole).
template <typename WorkARow>
void for_each_row(const torch::Tensor& rows, int64_t count, const WorkARow& work) {
  const int64_t* const kept = rows.defined() ? rows.data_ptr<int64_t>() : nullptr;
  for (int64_t i = 0; i < count; ++i) work(i, kept == nullptr ? i : kept[i]);
}

void take(const torch::Tensor& whole, const torch::Tensor& rows, const torch::Tensor& columns,
          torch::Tensor& part) {
  const int64_t width = part.size(1);
  for_each_row(rows, part.size(0), [&](int64_t to_row, int64_t from_row) {
    const float* const from = whole.data_ptr<float>() + from_row * whole.size(1);
    float* const to = part.data_ptr<float>() + to_row * width;
    if (!columns.defined()) {
      std::copy_n(from, width, to);
      return;
    }
    const int64_t* const kept = columns.data_ptr<int64_t>();
    for (int64_t i = 0; i < width; ++i) to[i] = from[kept[i]];
  });
}

void put(const torch::Tensor& part, const torch::Tensor& rows, const torch::Tensor& columns,
         torch::Tensor& whole) {
  const int64_t width = part.size(1);
  for_each_row(rows, part.size(0), [&](int64_t from_row, int64_t to_row) {
    const float* const from = part.data_ptr<float>() + from_row * width;
    float* const to = whole.data_ptr<float>() + to_row * whole.size(1);
    if (!columns.defined()) {
      std::copy_n(from, width, to);
      return;
    }
    const int64_t* const kept = columns.data_ptr<int64_t>();
    for (int64_t i = 0; i < width; ++i) to[kept[i]] = from[i];
  });
}

/// Which rows and columns are kept; not defined: all. As one argument, LibTorch asks for no gradient of them.
struct Kept {
  torch::Tensor rows;
  torch::Tensor columns;
};

class KeptWeights final : public torch::autograd::Function<KeptWeights> {
 public:
  static torch::Tensor forward(torch::autograd::AutogradContext* context, const torch::Tensor& weight,
                               const Kept& kept) {
    const auto& [rows, columns] = kept;
    context->saved_data["height"] = weight.size(0);
    context->saved_data["width"] = weight.size(1);
    context->saved_data["rows"] = rows;
    context->saved_data["columns"] = columns;
    torch::Tensor part = torch::empty({rows.defined() ? rows.numel() : weight.size(0),
                                       columns.defined() ? columns.numel() : weight.size(1)});
    take(weight.contiguous(), rows, columns, part);
    return part;
  }

  static torch::autograd::tensor_list backward(torch::autograd::AutogradContext* context,
                                               const torch::autograd::tensor_list& part_gradients) {
    auto& saved = context->saved_data;
    torch::Tensor gradient = torch::zeros({saved["height"].toInt(), saved["width"].toInt()});
    put(part_gradients[0].contiguous(), saved["rows"].toTensor(), saved["columns"].toTensor(), gradient);
    return {gradient, torch::Tensor()};
  }
};

}  // namespace

torch::Tensor kept_weights(const torch::Tensor& weight, const torch::Tensor& rows,
                           const torch::Tensor& columns) {
  if (!rows.defined() && !columns.defined()) return weight;
  if (weight.device().is_cpu() && weight.scalar_type() == torch::kFloat) {
    return KeptWeights::apply(weight, Kept{rows, columns});
  }
  torch::Tensor part = weight;
  if (rows.defined()) part = part.index_select(0, rows.to(weight.device()));
  if (columns.defined()) part = part.index_select(1, columns.to(weight.device()));
  return part;
}

}  // namespace knuckle
