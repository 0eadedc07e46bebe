// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/run_length_deflate.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstring>
#include <functional>
#include <queue>
#include <utility>

namespace knuckle {
namespace {

// RFC 1951, section 3.2.
constexpr std::size_t kEndOfBlock = 256;
constexpr std::size_t kFirstLength = 257;
constexpr std::size_t kSymbols = 286;  ///< bytes, end of block, lengths
constexpr std::size_t kShortestRun = 3;
constexpr std::size_t kLongestRun = 258;
constexpr int kLongestCode = 15;
constexpr int kLongestLengthCode = 7;
constexpr std::size_t kRepeatBefore = 16;  ///< the length before, 3 to 6 times
constexpr std::size_t kFewZeros = 17;      ///< 3 to 10
constexpr std::size_t kManyZeros = 18;     ///< 11 to 138
constexpr std::array<std::uint8_t, 19> kOrderOfLengthCodes{16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                                           11, 4,  12, 3, 13, 2, 14, 1, 15};
constexpr std::size_t kBlockBytes = std::size_t{1} << 16;  ///< few enough that codes follow the image

struct LengthCode {
  std::uint16_t symbol;
  std::uint16_t shortest;
  std::uint8_t extra_bits;
};

/// Codes 257 to 285: four of each number of extra bits, eight without any; the longest run has its own.
constexpr std::array<LengthCode, kLongestRun + 1> length_codes() {
  std::array<LengthCode, kLongestRun + 1> codes{};
  std::uint16_t symbol = kFirstLength;
  std::size_t run = kShortestRun;
  for (int extra = 0; extra <= 5; ++extra) {
    for (int i = 0; i < (extra == 0 ? 8 : 4); ++i, ++symbol) {
      const auto shortest = static_cast<std::uint16_t>(run);
      for (int j = 0; j < (1 << extra) && run < kLongestRun; ++j)
        codes[run++] = {symbol, shortest, static_cast<std::uint8_t>(extra)};
    }
  }
  codes[kLongestRun] = {kSymbols - 1, kLongestRun, 0};
  return codes;
}
constexpr std::array<LengthCode, kLongestRun + 1> kLengthCodes = length_codes();

/// How many bytes from `first` on are `value`.
std::size_t run_of(std::uint8_t value, const std::uint8_t* first, const std::uint8_t* end) {
  const std::uint64_t eight = 0x0101010101010101u * value;
  const std::uint8_t* at = first;
  for (std::uint64_t next = 0; end - at >= 8; at += 8) {
    std::memcpy(&next, at, sizeof(next));
    if (next == eight) continue;
    while (*at == value) ++at;
    return static_cast<std::size_t>(at - first);
  }
  while (at != end && *at == value) ++at;
  return static_cast<std::size_t>(at - first);
}

/// A byte below 256; else a run's length, 256 added: so often is the byte before it repeated.
using Token = std::uint16_t;
constexpr Token kRun = 256;

std::vector<Token> tokens_of(std::span<const std::uint8_t> bytes) {
  std::vector<Token> tokens;
  tokens.reserve(bytes.size());
  const std::uint8_t* const end = bytes.data() + bytes.size();
  for (const std::uint8_t* at = bytes.data(); at != end;) {
    const std::uint8_t value = *at++;
    tokens.push_back(value);
    if (at == end || *at != value) continue;
    std::size_t left = run_of(value, at, end);
    at += left;
    for (; left >= kShortestRun; left -= std::min(left, kLongestRun))
      tokens.push_back(static_cast<Token>(kRun + std::min(left, kLongestRun)));
    tokens.insert(tokens.end(), left, value);
  }
  return tokens;
}

/// Bits, the lowest of a byte first.
class BitWriter {
 public:
  explicit BitWriter(std::vector<std::uint8_t>& bytes) : bytes_(bytes) {}

  /// At most 32 bits.
  void put(std::uint32_t value, int bits) {
    waiting_ |= std::uint64_t{value} << count_;
    count_ += bits;
    if (count_ < 32) return;
    for (const int shift : {0, 8, 16, 24}) bytes_.push_back(static_cast<std::uint8_t>(waiting_ >> shift));
    waiting_ >>= 32;
    count_ -= 32;
  }
  /// The last byte is filled with zeros.
  void finish() {
    for (; count_ > 0; count_ -= 8, waiting_ >>= 8) bytes_.push_back(static_cast<std::uint8_t>(waiting_));
    count_ = 0;
  }

 private:
  std::vector<std::uint8_t>& bytes_;
  std::uint64_t waiting_ = 0;
  int count_ = 0;
};

std::uint32_t reversed(std::uint32_t code, int bits) {
  std::uint32_t result = 0;
  for (int i = 0; i < bits; ++i) result |= ((code >> i) & 1u) << (bits - 1 - i);
  return result;
}

/// The canonical codes of lengths (RFC 1951, section 3.2.2), with their first bit lowest.
class HuffmanCode {
 public:
  HuffmanCode(std::span<const std::uint32_t> counts, int longest)
      : lengths_(huffman_lengths(counts, longest)) {
    std::array<std::uint32_t, kLongestCode + 2> next{};
    for (const std::uint8_t length : lengths_) next[length + 1u] += length > 0 ? 1u : 0u;
    for (std::size_t bits = 1; bits < next.size(); ++bits) next[bits] = (next[bits - 1] + next[bits]) << 1;
    for (const std::uint8_t length : lengths_)
      codes_.push_back(length > 0 ? reversed(next[length]++, length) : 0);
  }

  const std::vector<std::uint8_t>& lengths() const { return lengths_; }
  void put(BitWriter& bits, std::size_t symbol) const { bits.put(codes_[symbol], lengths_[symbol]); }

 private:
  std::vector<std::uint8_t> lengths_;
  std::vector<std::uint32_t> codes_;
};

/// A symbol of the code that writes code lengths, and the bits that follow it.
struct LengthSymbol {
  std::uint8_t symbol;
  std::uint8_t extra;
  std::uint8_t extra_bits;
};

void add_zeros(std::size_t count, std::vector<LengthSymbol>& symbols) {
  for (; count >= 11; count -= std::min<std::size_t>(count, 138))
    symbols.push_back({kManyZeros, static_cast<std::uint8_t>(std::min<std::size_t>(count, 138) - 11), 7});
  if (count >= 3) {
    symbols.push_back({kFewZeros, static_cast<std::uint8_t>(count - 3), 3});
    count = 0;
  }
  symbols.insert(symbols.end(), count, LengthSymbol{0, 0, 0});
}

void add_repeats(std::uint8_t length, std::size_t count, std::vector<LengthSymbol>& symbols) {
  symbols.push_back({length, 0, 0});
  for (--count; count >= 3; count -= std::min<std::size_t>(count, 6))
    symbols.push_back({kRepeatBefore, static_cast<std::uint8_t>(std::min<std::size_t>(count, 6) - 3), 2});
  symbols.insert(symbols.end(), count, LengthSymbol{length, 0, 0});
}

std::vector<LengthSymbol> length_symbols(std::span<const std::uint8_t> lengths) {
  std::vector<LengthSymbol> symbols;
  for (std::size_t i = 0; i < lengths.size();) {
    std::size_t end = i;
    while (end < lengths.size() && lengths[end] == lengths[i]) ++end;
    if (lengths[i] == 0) {
      add_zeros(end - i, symbols);
    } else {
      add_repeats(lengths[i], end - i, symbols);
    }
    i = end;
  }
  return symbols;
}

/// What a block with codes of its own begins with (section 3.2.7). The only distance is 1, its code one bit.
void put_code(const HuffmanCode& code, BitWriter& bits) {
  std::vector<std::uint8_t> lengths = code.lengths();
  lengths.push_back(1);
  const std::vector<LengthSymbol> symbols = length_symbols(lengths);
  std::array<std::uint32_t, kOrderOfLengthCodes.size()> counts{};
  for (const LengthSymbol& s : symbols) ++counts[s.symbol];
  const HuffmanCode of_lengths(counts, kLongestLengthCode);
  bits.put(kSymbols - 257, 5);
  bits.put(0, 5);  // one distance
  bits.put(kOrderOfLengthCodes.size() - 4, 4);
  for (const std::uint8_t symbol : kOrderOfLengthCodes) bits.put(of_lengths.lengths()[symbol], 3);
  for (const LengthSymbol& s : symbols) {
    of_lengths.put(bits, s.symbol);
    bits.put(s.extra, s.extra_bits);
  }
}

void put_block(std::span<const std::uint8_t> bytes, bool is_last, BitWriter& bits) {
  const std::vector<Token> tokens = tokens_of(bytes);
  std::array<std::uint32_t, kSymbols> counts{};
  for (const Token token : tokens) ++counts[token < kRun ? token : kLengthCodes[token - kRun].symbol];
  ++counts[kEndOfBlock];
  const HuffmanCode code(counts, kLongestCode);
  bits.put(is_last ? 1 : 0, 1);
  bits.put(2, 2);  // codes of its own
  put_code(code, bits);
  for (const Token token : tokens) {
    if (token < kRun) {
      code.put(bits, token);
      continue;
    }
    const std::size_t run = token - kRun;
    const LengthCode& length = kLengthCodes[run];
    code.put(bits, length.symbol);
    bits.put(static_cast<std::uint32_t>(run - length.shortest), length.extra_bits);
    bits.put(0, 1);  // distance 1
  }
  code.put(bits, kEndOfBlock);
}

/// The lengths of the best code, however long; `counts` has at least two that are not 0.
std::vector<std::uint8_t> best_lengths(std::span<const std::uint32_t> counts) {
  using Entry = std::pair<std::uint64_t, std::size_t>;  // count, node: equal counts are told apart
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] > 0) open.emplace(counts[i], i);
  }
  std::vector<std::size_t> parents(counts.size(), 0);
  while (open.size() > 1) {
    const Entry a = open.top();
    open.pop();
    const Entry b = open.top();
    open.pop();
    parents[a.second] = parents[b.second] = parents.size();
    open.emplace(a.first + b.first, parents.size());
    parents.push_back(0);
  }
  std::vector<std::uint8_t> depths(parents.size(), 0);  // the root is the last
  for (std::size_t node = parents.size() - 1; node-- > 0;) {
    const bool is_there = node >= counts.size() || counts[node] > 0;
    if (is_there) depths[node] = static_cast<std::uint8_t>(depths[parents[node]] + 1);
  }
  depths.resize(counts.size());
  return depths;
}

}  // namespace

double share_of_repeats(std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return 0.0;
  std::size_t repeats = 0;
  for (std::size_t i = 1; i < bytes.size(); ++i) repeats += bytes[i] == bytes[i - 1] ? 1 : 0;
  return static_cast<double>(repeats) / static_cast<double>(bytes.size());
}

std::vector<std::uint8_t> huffman_lengths(std::span<const std::uint32_t> counts, int longest) {
  assert((std::size_t{1} << longest) >= counts.size());
  std::vector<std::uint32_t> flatter(counts.begin(), counts.end());
  const auto used = std::ranges::count_if(counts, [](std::uint32_t count) { return count > 0; });
  std::vector<std::uint8_t> lengths(counts.size(), 0);
  if (used < 2) {
    std::ranges::transform(counts, lengths.begin(), [](std::uint32_t count) { return count > 0 ? 1 : 0; });
    return lengths;
  }
  while (true) {
    lengths = best_lengths(flatter);
    if (std::ranges::max(lengths) <= longest) return lengths;
    for (std::uint32_t& count : flatter) count = (count + 1) / 2;
  }
}

std::vector<std::uint8_t> run_length_deflated(std::span<const std::uint8_t> bytes) {
  std::vector<std::uint8_t> stream;
  stream.reserve(bytes.size() / 4);
  BitWriter bits(stream);
  std::size_t first = 0;
  do {
    const std::size_t count = std::min(kBlockBytes, bytes.size() - first);
    put_block(bytes.subspan(first, count), first + count == bytes.size(), bits);
    first += count;
  } while (first < bytes.size());
  bits.finish();
  return stream;
}

}  // namespace knuckle
