// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace knuckle {

/// The values of a forest's leaves: one row per leaf, one column per target. With 8 or 16 bits a column is
/// kept as
///     value = offset + step * code,   step = (highest - lowest) / (2^bits - 1),   offset = lowest,
/// so that a value loses at most half a step; with 32 bits it is kept as it is.
class LeafTable {
 public:
  using Codes = std::variant<std::vector<std::uint8_t>, std::vector<std::uint16_t>, std::vector<float>>;

  LeafTable() = default;
  /// `values` are rows of `dimensions` entries; `bits` is 8, 16 or 32 (an Error otherwise).
  LeafTable(int dimensions, std::span<const float> values, int bits);
  /// Takes what a file holds. Throws an Error that starts with `origin` where the parts do not fit together.
  LeafTable(std::vector<float> offset, std::vector<float> step, Codes codes, const std::string& origin);

  int dimensions() const { return static_cast<int>(offset_.size()); }
  std::size_t leaf_count() const;
  int bits() const;

  /// Row `leaf` as numbers, into `row` (dimensions() entries).
  void decode(std::size_t leaf, std::span<float> row) const;
  /// All rows as numbers.
  std::vector<float> decoded() const;

  const std::vector<float>& offset() const { return offset_; }
  const std::vector<float>& step() const { return step_; }
  const Codes& codes() const { return codes_; }

 private:
  std::vector<float> offset_;
  std::vector<float> step_;
  Codes codes_;
};

class ModelFile;
class ModelWriter;

struct LeafCoding;

/// Adds the table to a file as it is, or coded (leaf_coding.h).
void write_leaves(ModelWriter& file, const LeafTable& leaves);
void write_leaves(ModelWriter& file, const LeafTable& leaves, const LeafCoding& coding);
/// Reads it back; coded leaves with 8 bits per value. Throws an Error that names the file where something is
/// missing or does not fit together.
LeafTable read_leaves(const ModelFile& file);

}  // namespace knuckle
