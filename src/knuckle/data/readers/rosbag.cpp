// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/rosbag.h"

#include <algorithm>
#include <set>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/text.h"
#include "knuckle/data/readers/byte_cursor.h"

namespace knuckle {
namespace {

constexpr auto kMostBytes = static_cast<std::uint64_t>(limits::kRecordingChunkBytes);
constexpr std::uint32_t kIndexVersion = 1;
constexpr std::uint32_t kIndexEntryBytes = 12;  // seconds, nanoseconds, offset

Packing packing_of(std::string_view name, std::string_view where) {
  if (name == "none") return Packing::none;
  if (name == "bz2") return Packing::bz2;
  if (name == "lz4") return Packing::lz4;
  fail("{}: the chunk has the compression '{:.40}', expected none, bz2 or lz4", where, printable(name));
}

}  // namespace

Rosbag::Rosbag(std::filesystem::path path) : file_(std::move(path)) {
  read_records(read_bag_header());
  if (chunks_.size() != chunk_count_ || connections_.size() != connection_count_) {
    fail("{}: the bag is cut short or damaged: has {} chunks and {} connections, expected {} and {}",
         file_.path().string(), chunks_.size(), connections_.size(), chunk_count_, connection_count_);
  }
}

/// Returns where the next record is.
std::uint64_t Rosbag::read_bag_header() {
  const std::string name = file_.path().string();
  const BagRecord header = file_.record_at(file_.first_record());
  if (header.fields.kind() != BagRecordKind::bag_header) {
    fail("{}: the bag is damaged: it does not begin with its header", name);
  }
  const std::string_view encryptor = header.fields.text("encryptor");
  if (!encryptor.empty() && encryptor != "rosbag/NoEncryptor") fail("{}: the bag is encrypted", name);
  const std::uint64_t index_at = header.fields.u64("index_pos");
  if (index_at == 0) fail("{}: the bag was not closed by its recorder; 'rosbag reindex' mends it", name);
  if (index_at > file_.size()) {
    fail("{}: the bag is cut short: it has {} bytes, and its index begins at {}", name, file_.size(),
         index_at);
  }
  connection_count_ = header.fields.u32("conn_count");
  chunk_count_ = header.fields.u32("chunk_count");
  return header.end();
}

void Rosbag::read_records(std::uint64_t at) {
  while (at < file_.size()) {
    const BagRecord record = file_.record_at(at);
    switch (record.fields.kind()) {
      case BagRecordKind::chunk:
        add_chunk(record);
        break;
      case BagRecordKind::index_data:
        add_listing(record);
        break;
      case BagRecordKind::connection:
        add_connection(record);
        break;
      case BagRecordKind::chunk_info:  // says what the chunks and their listings say
        break;
      default:
        fail("{}: the bag is damaged: a record of an unknown kind", file_.place(at));
    }
    at = record.end();
  }
  std::ranges::stable_sort(listings_, {}, &Listing::connection);
}

void Rosbag::add_connection(const BagRecord& record) {
  if (record.data_bytes > static_cast<std::uint64_t>(limits::kRecordHeaderBytes)) {
    fail("{}: the description of a connection has {} bytes, expected at most {}", file_.place(record.data_at),
         record.data_bytes, limits::kRecordHeaderBytes);
  }
  if (connections_.size() == static_cast<std::size_t>(limits::kConnections))
    fail("{}: has more than {} connections", file_.path().string(), limits::kConnections);
  const BagFields description(file_.read(record.data_at, record.data_bytes), file_.place(record.data_at));
  connections_.push_back({record.fields.u32("conn"), printable(record.fields.text("topic")),
                          std::string(description.text("type"))});
}

void Rosbag::add_chunk(const BagRecord& record) {
  const std::string where = file_.place(record.data_at);
  const Chunk chunk{record.data_at, record.data_bytes, record.fields.u32("size"),
                    packing_of(record.fields.text("compression"), where)};
  if (chunk.packing == Packing::none && chunk.bytes != chunk.packed_bytes) {
    fail("{}: the bag is damaged: a chunk has {} bytes, expected {}", where, chunk.packed_bytes, chunk.bytes);
  }
  const std::uint64_t most = std::max<std::uint64_t>(chunk.bytes, chunk.packed_bytes);
  // Chunks that are not packed are never read as a whole.
  if (chunk.packing != Packing::none && most > kMostBytes)
    fail("{}: a chunk has {} bytes, expected at most {}", where, most, kMostBytes);
  chunks_.push_back(chunk);
}

void Rosbag::add_listing(const BagRecord& record) {
  const std::string where = file_.place(record.data_at);
  const std::uint32_t version = record.fields.u32("ver");
  if (version != kIndexVersion) fail("{}: an index of version {}, expected 1", where, version);
  const std::uint32_t count = record.fields.u32("count");
  if (std::uint64_t{count} * kIndexEntryBytes != record.data_bytes) {
    fail("{}: the bag is damaged: {} entries in {} bytes", where, count, record.data_bytes);
  }
  if (chunks_.empty()) fail("{}: the bag is damaged: an index without a chunk", where);
  listings_.push_back(
      {record.fields.u32("conn"), static_cast<std::uint32_t>(chunks_.size() - 1), record.data_at, count});
}

void Rosbag::append_messages(const Listing& listing, std::vector<RecordedMessage>& messages) const {
  const std::vector<std::uint8_t> bytes =
      file_.read(listing.at, std::uint64_t{listing.count} * kIndexEntryBytes);
  ByteCursor cursor(bytes, "");
  for (std::uint32_t i = 0; i < listing.count; ++i) {
    const std::uint32_t seconds = cursor.u32();
    const std::uint32_t nanoseconds = cursor.u32();
    messages.push_back({listing.connection, listing.chunk, cursor.u32(), seconds + 1e-9 * nanoseconds});
  }
}

std::vector<RecordedMessage> Rosbag::messages_of(std::string_view topic) const {
  std::set<std::uint32_t> numbers;
  for (const BagConnection& connection : connections_) {
    if (connection.topic == topic) numbers.insert(connection.number);
  }
  std::vector<RecordedMessage> messages;
  for (const std::uint32_t number : numbers) {
    auto listing = std::ranges::lower_bound(listings_, number, {}, &Listing::connection);
    for (; listing != listings_.end() && listing->connection == number; ++listing)
      append_messages(*listing, messages);
  }
  std::ranges::stable_sort(
      messages, {}, [](const RecordedMessage& message) { return std::pair(message.chunk, message.offset); });
  return messages;
}

std::vector<std::uint8_t> Rosbag::read(const RecordedMessage& message, std::uint64_t most_bytes) const {
  return chunks_.at(message.chunk).packing == Packing::none ? read_plain(message, most_bytes)
                                                            : read_packed(message, most_bytes);
}

void Rosbag::require_message(const BagFields& fields, const RecordedMessage& message,
                             std::string_view where) const {
  if (fields.kind() != BagRecordKind::message || fields.u32("conn") != message.connection)
    fail("{}: the bag is damaged: not the message that its index says", where);
}

std::vector<std::uint8_t> Rosbag::read_plain(const RecordedMessage& message, std::uint64_t most_bytes) const {
  const Chunk& chunk = chunks_.at(message.chunk);
  const std::uint64_t at = chunk.at + message.offset;
  const BagRecord record = file_.record_at(at, chunk.at + chunk.packed_bytes);
  require_message(record.fields, message, file_.place(at));
  if (record.data_bytes > kMostBytes) {
    fail("{}: a message has {} bytes, expected at most {}", file_.place(at), record.data_bytes, kMostBytes);
  }
  return file_.read(record.data_at, std::min(record.data_bytes, most_bytes));
}

std::vector<std::uint8_t> Rosbag::read_packed(const RecordedMessage& message,
                                              std::uint64_t most_bytes) const {
  const std::shared_ptr<const ChunkCache::Bytes> chunk = unpacked_chunk(message.chunk);
  const std::string where =
      fmt::format("{}, {} bytes into its chunk", file_.place(chunks_[message.chunk].at), message.offset);
  ByteCursor cursor(*chunk, where);
  cursor.skip(message.offset);
  const BagFields fields(cursor.take(cursor.u32()), where);
  require_message(fields, message, where);
  const std::span<const std::uint8_t> content = cursor.take(cursor.u32());
  const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(content.size(), most_bytes));
  return {content.begin(), content.begin() + static_cast<std::ptrdiff_t>(count)};
}

std::shared_ptr<const ChunkCache::Bytes> Rosbag::unpacked_chunk(std::uint32_t number) const {
  const Chunk& chunk = chunks_.at(number);
  return unpacked_.get(number, chunk.bytes, [&] {
    return unpack(file_.read(chunk.at, chunk.packed_bytes), chunk.packing, chunk.bytes,
                  file_.place(chunk.at));
  });
}

}  // namespace knuckle
