// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/deflate.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstring>

#include "knuckle/core/huffman_code.h"

namespace knuckle {
namespace {

static_assert(std::endian::native == std::endian::little, "runs and bits are handled as little-endian words");

// RFC 1951, sections 3.2.5 to 3.2.7.
constexpr std::size_t kEndOfBlock = 256;
constexpr std::size_t kFirstLengthSymbol = 257;
constexpr std::size_t kSymbols = 286;
constexpr int kLongestCode = 15;
constexpr int kLongestLengthCode = 7;
constexpr std::size_t kShortestRun = 3;
constexpr std::size_t kLongestRun = 258;
constexpr std::array<int, 29> kRunBase{3,  4,  5,  6,  7,  8,  9,  10, 11,  13,  15,  17,  19,  23, 27,
                                       31, 35, 43, 51, 59, 67, 83, 99, 115, 131, 163, 195, 227, 258};
constexpr std::array<int, 29> kRunExtraBits{0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2,
                                            2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0};
constexpr std::array<std::size_t, 19> kLengthCodeOrder{16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                                       11, 4,  12, 3, 13, 2, 14, 1, 15};

/// A literal is its value, a run of n bytes like the one before kFirstRunToken + n - kShortestRun.
using Token = std::uint16_t;
constexpr std::size_t kFirstRunToken = 256;
constexpr std::size_t kTokens = kFirstRunToken + kLongestRun - kShortestRun + 1;

class BitStream {
 public:
  explicit BitStream(std::size_t expected_bytes) { bytes_.reserve(expected_bytes); }

  void put(std::uint64_t bits, int count) {
    pending_ |= bits << pending_count_;
    pending_count_ += count;
    if (pending_count_ >= 32) flush_word();
  }
  void put(const BitCode& code) { put(code.bits, code.length); }

  /// The stream so far, filled up to a whole byte.
  std::vector<std::uint8_t> finished() {
    for (; pending_count_ > 0; pending_count_ -= 8, pending_ >>= 8)
      bytes_.push_back(static_cast<std::uint8_t>(pending_));
    return std::move(bytes_);
  }

 private:
  void flush_word() {
    const auto word = static_cast<std::uint32_t>(pending_);
    bytes_.resize(bytes_.size() + sizeof(word));
    std::memcpy(bytes_.data() + bytes_.size() - sizeof(word), &word, sizeof(word));
    pending_ >>= 32;
    pending_count_ -= 32;
  }

  std::vector<std::uint8_t> bytes_;
  std::uint64_t pending_ = 0;
  int pending_count_ = 0;
};

/// How many bytes from `first` on are `value`.
std::size_t run_length(const std::uint8_t* first, const std::uint8_t* last, std::uint8_t value) {
  constexpr std::uint64_t kEachByte = 0x0101010101010101u;
  const std::uint8_t* place = first;
  for (; last - place >= 8; place += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, place, sizeof(word));
    word ^= kEachByte * value;
    if (word != 0) return static_cast<std::size_t>(place - first) + std::countr_zero(word) / 8u;
  }
  while (place != last && *place == value) ++place;
  return static_cast<std::size_t>(place - first);
}

std::vector<Token> tokens_of(std::span<const std::uint8_t> bytes, std::size_t begin, std::size_t end) {
  std::vector<Token> tokens;
  tokens.reserve((end - begin) / 4);
  const auto* const data = bytes.data();
  for (std::size_t i = begin; i < end;) {
    if (i > 0 && data[i] == data[i - 1]) {
      const std::size_t longest = std::min(end - i, kLongestRun);
      const std::size_t run = run_length(data + i, data + i + longest, data[i - 1]);
      if (run >= kShortestRun) {
        tokens.push_back(static_cast<Token>(kFirstRunToken + run - kShortestRun));
        i += run;
        continue;
      }
    }
    tokens.push_back(data[i++]);
  }
  return tokens;
}

/// Which of kRunBase a run of `length` belongs to.
std::size_t run_class(int length) {
  return static_cast<std::size_t>(std::ranges::upper_bound(kRunBase, length) - kRunBase.begin()) - 1;
}

std::size_t symbol_of(std::size_t token) {
  if (token < kFirstRunToken) return token;
  return kFirstLengthSymbol + run_class(static_cast<int>(token - kFirstRunToken + kShortestRun));
}

/// How often each symbol of the block occurs, its end included.
std::vector<std::uint32_t> symbol_counts(std::span<const Token> tokens) {
  std::array<std::uint32_t, kTokens> token_counts{};
  for (const Token token : tokens) ++token_counts[token];
  std::vector<std::uint32_t> counts(kSymbols, 0);
  for (std::size_t token = 0; token < kTokens; ++token)
    if (token_counts[token] > 0) counts[symbol_of(token)] += token_counts[token];
  counts[kEndOfBlock] = 1;
  return counts;
}

/// The bits of each token: a run's are its code, what it has beyond the class's shortest, and the distance,
/// which is always 1 and takes one bit, 0.
std::array<BitCode, kTokens> token_codes(std::span<const BitCode> code) {
  std::array<BitCode, kTokens> codes;
  std::copy_n(code.begin(), kFirstRunToken, codes.begin());
  for (std::size_t token = kFirstRunToken; token < kTokens; ++token) {
    const auto length = static_cast<int>(token - kFirstRunToken + kShortestRun);
    const std::size_t group = run_class(length);
    const BitCode& symbol = code[kFirstLengthSymbol + group];
    const auto beyond = static_cast<std::uint32_t>(length - kRunBase[group]);
    codes[token] = {symbol.bits | beyond << symbol.length, symbol.length + kRunExtraBits[group] + 1};
  }
  return codes;
}

/// One entry of a block's table of code lengths: a length, or 17 or 18 for a run of zeros.
struct LengthEntry {
  std::size_t symbol;
  int extra = 0;
  int extra_bits = 0;
};

std::vector<LengthEntry> length_entries(std::span<const int> lengths) {
  constexpr std::ptrdiff_t kShortRun = 3;
  constexpr std::ptrdiff_t kLongRun = 11;
  constexpr std::ptrdiff_t kMostZeros = 138;
  std::vector<LengthEntry> entries;
  for (auto place = lengths.begin(); place != lengths.end();) {
    const auto next = std::find_if(place, lengths.end(), [](int length) { return length != 0; });
    const std::ptrdiff_t zeros = std::min(next - place, kMostZeros);
    if (zeros >= kLongRun) {
      entries.push_back({18, static_cast<int>(zeros - kLongRun), 7});
    } else if (zeros >= kShortRun) {
      entries.push_back({17, static_cast<int>(zeros - kShortRun), 3});
    } else {
      entries.push_back({static_cast<std::size_t>(*place)});
    }
    place += zeros >= kShortRun ? zeros : 1;
  }
  return entries;
}

/// The head of a block: the lengths of its codes, coded themselves (RFC 1951, 3.2.7).
void put_code_lengths(BitStream& stream, std::vector<int> lengths) {
  lengths.push_back(1);  // of the only distance
  const std::vector<LengthEntry> entries = length_entries(lengths);
  std::vector<std::uint32_t> counts(kLengthCodeOrder.size(), 0);
  for (const LengthEntry& entry : entries) ++counts[entry.symbol];
  const std::vector<int> entry_lengths = huffman_lengths(counts, kLongestLengthCode);
  const std::vector<BitCode> code = canonical_code(entry_lengths);
  stream.put(kSymbols - 257, 5);
  stream.put(0, 5);  // one distance
  stream.put(kLengthCodeOrder.size() - 4, 4);
  for (const std::size_t symbol : kLengthCodeOrder)
    stream.put(static_cast<std::uint64_t>(entry_lengths[symbol]), 3);
  for (const LengthEntry& entry : entries) {
    stream.put(code[entry.symbol]);
    stream.put(static_cast<std::uint64_t>(entry.extra), entry.extra_bits);
  }
}

void put_block(BitStream& stream, std::span<const Token> tokens, std::uint64_t is_last) {
  constexpr std::uint64_t kOwnCode = 2;
  stream.put(is_last, 1);
  stream.put(kOwnCode, 2);
  std::vector<int> lengths = huffman_lengths(symbol_counts(tokens), kLongestCode);
  const std::vector<BitCode> code = canonical_code(lengths);
  put_code_lengths(stream, std::move(lengths));
  const std::array<BitCode, kTokens> codes = token_codes(code);
  for (const Token token : tokens) stream.put(codes[token]);
  stream.put(code[kEndOfBlock]);
}

}  // namespace

std::vector<std::uint8_t> deflated(std::span<const std::uint8_t> bytes, std::size_t block_size) {
  assert(block_size > 0);
  BitStream stream(bytes.size() / 4);
  stream.put(0x0178, 16);  // RFC 1950: deflate, 32 KiB window, fastest
  for (std::size_t begin = 0; begin == 0 || begin < bytes.size(); begin += block_size) {
    const std::size_t end = std::min(begin + block_size, bytes.size());
    put_block(stream, tokens_of(bytes, begin, end), end == bytes.size() ? 1 : 0);
  }
  std::vector<std::uint8_t> result = stream.finished();
  const std::uint32_t sum = adler32(bytes);
  for (int shift = 24; shift >= 0; shift -= 8) result.push_back(static_cast<std::uint8_t>(sum >> shift));
  return result;
}

std::vector<std::uint8_t> shuffled(std::span<const std::uint16_t> values) {
  std::vector<std::uint8_t> bytes(2 * values.size());
  for (std::size_t i = 0; i < values.size(); ++i) bytes[i] = static_cast<std::uint8_t>(values[i]);
  for (std::size_t i = 0; i < values.size(); ++i)
    bytes[values.size() + i] = static_cast<std::uint8_t>(values[i] >> 8);
  return bytes;
}

std::uint32_t adler32(std::span<const std::uint8_t> bytes) {
  constexpr std::uint32_t kModulus = 65521;
  constexpr std::size_t kAtOnce = 4096;  // sums of so many fit 32 bits
  std::uint32_t low = 1;
  std::uint32_t high = 0;
  while (!bytes.empty()) {
    const std::span<const std::uint8_t> part = bytes.first(std::min(bytes.size(), kAtOnce));
    const auto count = static_cast<std::uint32_t>(part.size());
    std::uint32_t sum = 0;
    std::uint32_t weighted = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      sum += part[i];
      weighted += (count - i) * part[i];
    }
    high = (high + count * low + weighted % kModulus) % kModulus;
    low = (low + sum) % kModulus;
    bytes = bytes.subspan(part.size());
  }
  return high << 16 | low;
}

}  // namespace knuckle
