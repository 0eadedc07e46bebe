// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/mcap.h"

#include <algorithm>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/text.h"
#include "knuckle/data/readers/byte_cursor.h"
#include "knuckle/storage/deflate.h"

namespace knuckle {
namespace {

constexpr auto kMostChunkBytes = static_cast<std::uint64_t>(limits::kRecordingChunkBytes);
constexpr std::uint64_t kMostNamesBytes = 4 * limits::kNameLength;  // of a schema or channel
constexpr std::uint64_t kMessageHeadBytes = 2 + 4 + 8 + 8;          // channel, number, two times
constexpr std::uint64_t kIndexEntryBytes = 8 + 8;                   // time, offset
/// The chunk of a message that lies in none; its offset is that of its record in the file.
constexpr std::uint32_t kNoChunk = ~std::uint32_t{0};

double seconds_of(std::uint64_t nanoseconds) {
  return 1e-9 * static_cast<double>(nanoseconds);
}

std::string take_name(ByteCursor& cursor) {
  return std::string(cursor.text(cursor.u32()));
}

Packing packing_of(std::string_view name, std::string_view where) {
  if (name.empty()) return Packing::none;
  if (name == "lz4") return Packing::lz4;
  if (name == "zstd") return Packing::zstd;
  fail("{}: the chunk has the compression '{:.40}', expected none, lz4 or zstd", where, printable(name));
}

}  // namespace

Mcap::Mcap(std::filesystem::path path, std::vector<std::string> types)
    : file_(std::move(path)), types_(std::move(types)) {
  walk_records();
  list_messages();
  check_counts();
  if (has_loose_messages_ && sum_of_data_ != 0) check_sum_of_data();
}

void Mcap::walk_records() {
  std::uint64_t at = file_.first_record();
  while (at < file_.records_end()) {
    const McapRecord record = file_.record_at(at);
    add_record(record);
    at = record.end();
  }
}

void Mcap::add_record(const McapRecord& record) {
  const std::string where = file_.place(record.at);
  switch (record.kind) {
    case McapRecordKind::schema:
      return add_schema(file_.start_of(record, kMostNamesBytes), where);
    case McapRecordKind::channel:
      return add_channel(file_.start_of(record, kMostNamesBytes), where);
    case McapRecordKind::message:
      return add_message(file_.start_of(record, kMessageHeadBytes), {0, kNoChunk, record.at, 0.0}, where);
    case McapRecordKind::chunk:
      return add_chunk(record);
    case McapRecordKind::message_index:
      return add_listing(record);
    case McapRecordKind::statistics:
      return add_statistics(record);
    case McapRecordKind::data_end: {
      const std::vector<std::uint8_t> content = file_.start_of(record, sizeof sum_of_data_);
      data_end_ = record.at;
      sum_of_data_ = ByteCursor(content, where).u32();
      return;
    }
    default:  // attachments, metadata, what repeats the rest, and what later revisions add
      return;
  }
}

void Mcap::add_schema(Bytes content, std::string_view where) {
  ByteCursor cursor(content, where);
  const std::uint16_t number = cursor.u16();
  schemas_.try_emplace(number, take_name(cursor));
}

/// Those that are repeated, as in the summary, change nothing.
void Mcap::add_channel(Bytes content, std::string_view where) {
  ByteCursor cursor(content, where);
  const ChannelNumber number = cursor.u16();
  if (channels_.contains(number)) return;
  if (channels_.size() == static_cast<std::size_t>(limits::kConnections))
    fail("{}: has more than {} channels", file_.path().string(), limits::kConnections);
  const auto schema = schemas_.find(cursor.u16());
  const std::string topic = printable(take_name(cursor));
  const bool is_listed = schema != schemas_.end() && take_name(cursor) == "cdr" &&
                         std::ranges::find(types_, schema->second) != types_.end();
  channels_[number] = is_listed ? Channel{topic, schema->second, {}} : Channel{};
}

Mcap::Channel& Mcap::channel_of(ChannelNumber number, std::string_view where) {
  const auto channel = channels_.find(number);
  if (channel == channels_.end()) {
    fail("{}: the file is damaged: a message of the channel {}, which is described nowhere before it", where,
         number);
  }
  return channel->second;
}

void Mcap::require_room(std::uint64_t messages) const {
  if (messages > static_cast<std::uint64_t>(limits::kRecordedMessages) - listed_) {
    fail("{}: has more than {} images and camera infos", file_.path().string(), limits::kRecordedMessages);
  }
}

void Mcap::append(Channel& channel, const RecordedMessage& message) {
  require_room(1);
  channel.messages.push_back(message);
  ++listed_;
}

void Mcap::add_message(Bytes content, RecordedMessage message, std::string_view where) {
  ByteCursor cursor(content, where);
  const ChannelNumber number = cursor.u16();
  Channel& channel = channel_of(number, where);
  cursor.skip(4);
  const std::uint64_t time = cursor.u64();
  cursor.skip(8);
  if (channel.topic.empty()) return;
  message.connection = number;
  message.recorded_s = seconds_of(time);
  append(channel, message);
  has_loose_messages_ = has_loose_messages_ || message.chunk == kNoChunk;
}

void Mcap::add_chunk(const McapRecord& record) {
  constexpr std::uint64_t kTimesBytes = 16;
  constexpr std::uint64_t kMostHeadBytes = 128;
  const std::string where = file_.place(record.at);
  const std::vector<std::uint8_t> head = file_.start_of(record, kMostHeadBytes);
  ByteCursor cursor(head, where);
  cursor.skip(kTimesBytes);
  Chunk chunk;
  chunk.bytes = cursor.u64();
  chunk.sum = cursor.u32();
  chunk.packing = packing_of(cursor.text(cursor.u32()), where);
  chunk.packed_bytes = cursor.u64();
  const std::uint64_t head_bytes = head.size() - cursor.left();
  chunk.at = record.data_at + head_bytes;
  if (chunk.packed_bytes > record.data_bytes - head_bytes) {
    fail("{}: the file is damaged: a chunk has {} bytes, and {} are left", where, chunk.packed_bytes,
         record.data_bytes - head_bytes);
  }
  const std::uint64_t most = std::max(chunk.bytes, chunk.packed_bytes);
  if (most > kMostChunkBytes)
    fail("{}: a chunk has {} bytes, expected at most {}", where, most, kMostChunkBytes);
  chunks_.push_back(chunk);
}

void Mcap::add_listing(const McapRecord& record) {
  constexpr std::uint64_t kHeadBytes = 2 + 4;
  const std::string where = file_.place(record.at);
  const std::vector<std::uint8_t> head = file_.start_of(record, kHeadBytes);
  ByteCursor cursor(head, where);
  Listing listing;
  listing.channel = cursor.u16();
  const std::uint64_t bytes = cursor.u32();
  if (bytes > record.data_bytes - kHeadBytes || bytes % kIndexEntryBytes != 0)
    fail("{}: the file is damaged: an index of {} bytes in {}", where, bytes, record.data_bytes);
  if (chunks_.empty()) fail("{}: the file is damaged: an index without a chunk", where);
  listing.chunk = static_cast<std::uint32_t>(chunks_.size() - 1);
  listing.at = record.data_at + kHeadBytes;
  listing.count = bytes / kIndexEntryBytes;
  listings_.push_back(listing);
}

void Mcap::add_statistics(const McapRecord& record) {
  constexpr std::uint64_t kBeforeCounts = 8 + 2 + 4 + 4 + 4 + 4 + 8 + 8;
  const std::string where = file_.place(record.at);
  const std::vector<std::uint8_t> content = file_.content_of(record);
  ByteCursor cursor(content, where);
  cursor.skip(kBeforeCounts);
  ByteCursor counts(cursor.take(cursor.u32()), where);
  while (counts.left() > 0) {
    const ChannelNumber number = counts.u16();
    counts_[number] = counts.u64();
  }
}

/// Indexes are believed where statistics tell that they are whole. Chunks without one, and those whose index
/// tells of channels that no record outside of chunks describes, are looked through.
void Mcap::list_messages() {
  if (!counts_.empty()) {
    for (const Listing& listed : listings_) chunks_[listed.chunk].is_listed = true;
  }
  for (const Chunk& chunk : chunks_) {
    if (!chunk.is_listed) require_unpackable(chunk.bytes);
  }
  auto listing = listings_.begin();
  for (std::uint32_t number = 0; number < chunks_.size(); ++number) {
    auto end = listing;
    while (end != listings_.end() && end->chunk == number) ++end;
    const bool is_described =
        std::all_of(listing, end, [&](const Listing& listed) { return channels_.contains(listed.channel); });
    if (!chunks_[number].is_listed || !is_described) scan_chunk(number);
    for (; listing != end; ++listing) {
      if (chunks_[number].is_listed) read_listing(*listing);
    }
  }
}

/// A byte of zstd may stand for tens of thousands: what is unpacked only to look for messages is bounded.
void Mcap::require_unpackable(std::uint64_t bytes) {
  constexpr auto kTimes = static_cast<std::uint64_t>(limits::kUnpackedTimes);
  const std::uint64_t most = static_cast<std::uint64_t>(limits::kUnpackedBytes) + kTimes * file_.size();
  scanned_bytes_ += bytes;
  if (scanned_bytes_ > most) {
    fail(
        "{}: has no index, and unpacks to more than {} bytes, expected at most {} times its {}; "
        "'mcap recover' makes an index",
        file_.path().string(), most, kTimes, file_.size());
  }
}

void Mcap::scan_chunk(std::uint32_t number) {
  const std::string where = file_.place(chunks_[number].at);
  if (chunks_[number].is_listed) require_unpackable(chunks_[number].bytes);
  const std::shared_ptr<const ChunkCache::Bytes> chunk = unpacked_chunk(number);
  ByteCursor cursor(*chunk, where);
  while (cursor.left() > 0) {
    const std::uint64_t offset = chunk->size() - cursor.left();
    const auto kind = static_cast<McapRecordKind>(cursor.u8());
    const Bytes content = cursor.take(cursor.u64());
    if (kind == McapRecordKind::schema) add_schema(content, where);
    if (kind == McapRecordKind::channel) add_channel(content, where);
    if (kind == McapRecordKind::message && !chunks_[number].is_listed)
      add_message(content, {0, number, offset, 0.0}, where);
  }
}

void Mcap::read_listing(const Listing& listing) {
  Channel& channel = channel_of(listing.channel, file_.place(listing.at));
  if (channel.topic.empty()) return;
  require_room(listing.count);
  const std::vector<std::uint8_t> entries = file_.read(listing.at, listing.count * kIndexEntryBytes);
  ByteCursor cursor(entries, "");
  for (std::uint64_t i = 0; i < listing.count; ++i) {
    const double recorded_s = seconds_of(cursor.u64());
    append(channel, {listing.channel, listing.chunk, cursor.u64(), recorded_s});
  }
}

void Mcap::check_counts() const {
  for (const auto& [number, expected] : counts_) {
    const auto channel = channels_.find(number);
    if (channel == channels_.end() || channel->second.topic.empty()) continue;
    const std::size_t found = channel->second.messages.size();
    if (found != expected) {
      fail("{}: the file is damaged: has {} messages on the topic {}, expected {}", file_.path().string(),
           found, channel->second.topic, expected);
    }
  }
}

/// The specification does not say whether the file's first bytes and its header count; writers differ.
void Mcap::check_sum_of_data() const {
  const std::uint64_t after_header = file_.record_at(file_.first_record()).end();
  if (is_sum(file_.sum_of(0, data_end_), sum_of_data_)) return;
  if (is_sum(file_.sum_of(after_header, data_end_), sum_of_data_)) return;
  fail("{}: the file is damaged: the sum of its data is another", file_.path().string());
}

std::vector<std::string> Mcap::topics_of(std::string_view type) const {
  std::vector<std::string> topics;
  for (const auto& [number, channel] : channels_) {
    if (!channel.topic.empty() && channel.type == type) topics.push_back(channel.topic);
  }
  std::ranges::sort(topics);
  topics.erase(std::unique(topics.begin(), topics.end()), topics.end());
  return topics;
}

std::vector<RecordedMessage> Mcap::messages_of(std::string_view topic) const {
  std::vector<RecordedMessage> messages;
  for (const auto& [number, channel] : channels_) {
    if (channel.topic == topic)
      messages.insert(messages.end(), channel.messages.begin(), channel.messages.end());
  }
  std::ranges::stable_sort(
      messages, {}, [](const RecordedMessage& message) { return std::pair(message.chunk, message.offset); });
  return messages;
}

std::shared_ptr<const ChunkCache::Bytes> Mcap::unpacked_chunk(std::uint32_t number) const {
  const Chunk& chunk = chunks_.at(number);
  return unpacked_.get(number, chunk.bytes, [&] {
    const std::string where = file_.place(chunk.at);
    std::vector<std::uint8_t> bytes =
        unpack(file_.read(chunk.at, chunk.packed_bytes), chunk.packing, chunk.bytes, where);
    if (chunk.sum != 0 && !is_sum(crc32(bytes), chunk.sum))
      fail("{}: the chunk is damaged: its sum is another", where);
    return bytes;
  });
}

Mcap::Content Mcap::read_loose(std::uint64_t at, std::uint64_t most_bytes) const {
  const McapRecord record = file_.record_at(at);
  if (record.data_bytes > kMostChunkBytes) {
    fail("{}: a message has {} bytes, expected at most {}", file_.place(at), record.data_bytes,
         kMostChunkBytes);
  }
  return {record.kind, file_.start_of(record, most_bytes)};
}

Mcap::Content Mcap::read_in_chunk(const RecordedMessage& message, std::uint64_t most_bytes,
                                  std::string_view where) const {
  const std::shared_ptr<const ChunkCache::Bytes> chunk = unpacked_chunk(message.chunk);
  ByteCursor cursor(*chunk, where);
  cursor.skip(message.offset);
  const auto kind = static_cast<McapRecordKind>(cursor.u8());
  const Bytes all = cursor.take(cursor.u64());
  const Bytes start = all.first(static_cast<std::size_t>(std::min<std::uint64_t>(all.size(), most_bytes)));
  return {kind, {start.begin(), start.end()}};
}

std::vector<std::uint8_t> Mcap::read(const RecordedMessage& message, std::uint64_t most_bytes) const {
  const bool is_loose = message.chunk == kNoChunk;
  const std::string where = is_loose ? file_.place(message.offset)
                                     : fmt::format("{}, {} bytes into its chunk",
                                                   file_.place(chunks_.at(message.chunk).at), message.offset);
  most_bytes = std::min(most_bytes, kMostChunkBytes) + kMessageHeadBytes;
  const Content content =
      is_loose ? read_loose(message.offset, most_bytes) : read_in_chunk(message, most_bytes, where);
  ByteCursor cursor(content.bytes, where);
  if (content.kind != McapRecordKind::message || cursor.u16() != message.connection)
    fail("{}: the file is damaged: not the message that its index says", where);
  cursor.skip(kMessageHeadBytes - 2);
  const Bytes data = cursor.take(cursor.left());
  return {data.begin(), data.end()};
}

}  // namespace knuckle
