// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/data/readers/chunk_cache.h"
#include "knuckle/data/readers/mcap_file.h"
#include "knuckle/data/readers/ros_recording.h"
#include "knuckle/data/readers/unpack.h"

namespace knuckle {

/// An MCAP file (specification of MCAP, version 0) with messages of ROS 2: topics of some types, and their
/// messages at random. Opening reads the heads of all records, and the indexes of messages where the file's
/// statistics confirm them. A chunk without such an index, or with one that names what is described nowhere
/// else, is unpacked then, once. Sums are checked where the file has them: of the summary, of each chunk as
/// it is unpacked, and of the whole file where messages lie outside of chunks. Safe to be read by many
/// threads.
class Mcap {
 public:
  /// Lists the messages of these types, as in "sensor_msgs/msg/Image", that are serialised as CDR. Throws an
  /// Error that names the file where it is no MCAP file, damaged, cut short, was not closed by its recorder,
  /// or has a chunk of an unknown compression or above the limit.
  Mcap(std::filesystem::path path, std::vector<std::string> types);

  const std::filesystem::path& path() const { return file_.path(); }
  /// The topics of a type, each once, sorted.
  std::vector<std::string> topics_of(std::string_view type) const;
  /// All messages of a topic, in the order of the file; those outside of chunks come last.
  std::vector<RecordedMessage> messages_of(std::string_view topic) const;
  /// The content of a message, or its first bytes where it has more than `most_bytes`.
  std::vector<std::uint8_t> read(const RecordedMessage& message, std::uint64_t most_bytes) const;

 private:
  using Bytes = std::span<const std::uint8_t>;
  using ChannelNumber = std::uint16_t;

  struct Chunk {
    std::uint64_t at = 0;  ///< its packed bytes
    std::uint64_t packed_bytes = 0;
    std::uint64_t bytes = 0;
    std::uint32_t sum = 0;  ///< of the unpacked bytes; 0: not known
    Packing packing = Packing::none;
    bool is_listed = false;  ///< its messages stand in `listings_`
  };
  /// Where the file lists messages of one channel in one chunk.
  struct Listing {
    ChannelNumber channel = 0;
    std::uint32_t chunk = 0;
    std::uint64_t at = 0;
    std::uint64_t count = 0;
  };
  struct Channel {
    std::string topic;  ///< of a listed type; else empty
    std::string type;
    std::vector<RecordedMessage> messages;
  };

  /// Of a record, or its first bytes.
  struct Content {
    McapRecordKind kind;
    std::vector<std::uint8_t> bytes;
  };

  void walk_records();
  void add_record(const McapRecord& record);
  void add_schema(Bytes content, std::string_view where);
  void add_channel(Bytes content, std::string_view where);
  void add_message(Bytes content, RecordedMessage message, std::string_view where);
  void add_chunk(const McapRecord& record);
  void add_listing(const McapRecord& record);
  void add_statistics(const McapRecord& record);
  void list_messages();
  void require_unpackable(std::uint64_t bytes);
  void scan_chunk(std::uint32_t number);
  void read_listing(const Listing& listing);
  void check_counts() const;
  void check_sum_of_data() const;
  Channel& channel_of(ChannelNumber number, std::string_view where);
  void append(Channel& channel, const RecordedMessage& message);
  void require_room(std::uint64_t messages) const;
  std::shared_ptr<const ChunkCache::Bytes> unpacked_chunk(std::uint32_t number) const;
  Content read_loose(std::uint64_t at, std::uint64_t most_bytes) const;
  Content read_in_chunk(const RecordedMessage& message, std::uint64_t most_bytes,
                        std::string_view where) const;

  McapFile file_;
  std::vector<std::string> types_;
  std::map<std::uint16_t, std::string> schemas_;  ///< names of types
  std::map<ChannelNumber, Channel> channels_;
  std::vector<Chunk> chunks_;
  std::vector<Listing> listings_;                  ///< in the order of the file
  std::map<ChannelNumber, std::uint64_t> counts_;  ///< of messages, as the file's statistics say
  std::uint64_t listed_ = 0;                       ///< messages
  std::uint64_t scanned_bytes_ = 0;                ///< unpacked of chunks that are not listed
  bool has_loose_messages_ = false;
  std::uint64_t data_end_ = 0;     ///< where the data section ends [bytes]
  std::uint32_t sum_of_data_ = 0;  ///< 0: not known
  ChunkCache unpacked_;
};

}  // namespace knuckle
