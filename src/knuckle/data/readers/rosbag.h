// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/data/readers/bag_file.h"
#include "knuckle/data/readers/chunk_cache.h"
#include "knuckle/data/readers/ros_recording.h"
#include "knuckle/data/readers/unpack.h"

namespace knuckle {

/// A topic as one of its publishers wrote it.
struct BagConnection {
  std::uint32_t number = 0;  ///< by which messages name it
  std::string topic;         ///< as in "/camera/depth/image_raw"
  std::string type;          ///< as in "sensor_msgs/Image"
};

/// A ROS 1 bag of format 2.0: topics, and messages at random. Opening reads the headers of all records and
/// unpacks nothing. Unpacked chunks are kept while they are the last that were asked for: a few, of 64 MiB
/// together or a single larger one. Safe to be read by many threads.
class Rosbag {
 public:
  /// Throws an Error that names the file where it is not a bag, damaged, cut short, encrypted, was not closed
  /// by its recorder, or has a chunk of an unknown compression or above the limit.
  explicit Rosbag(std::filesystem::path path);

  const std::filesystem::path& path() const { return file_.path(); }
  const std::vector<BagConnection>& connections() const { return connections_; }
  /// All messages of a topic, in the order of the file.
  std::vector<RecordedMessage> messages_of(std::string_view topic) const;
  /// The content of a message, or its first bytes where it has more than `most_bytes`.
  std::vector<std::uint8_t> read(const RecordedMessage& message,
                                 std::uint64_t most_bytes = ~std::uint64_t{0}) const;

 private:
  struct Chunk {
    std::uint64_t at = 0;  ///< its packed bytes
    std::uint64_t packed_bytes = 0;
    std::uint32_t bytes = 0;
    Packing packing = Packing::none;
  };
  /// Where the file lists messages of one connection in one chunk.
  struct Listing {
    std::uint32_t connection = 0;
    std::uint32_t chunk = 0;
    std::uint64_t at = 0;
    std::uint32_t count = 0;
  };
  std::uint64_t read_bag_header();
  void read_records(std::uint64_t at);
  void add_connection(const BagRecord& record);
  void add_chunk(const BagRecord& record);
  void add_listing(const BagRecord& record);
  void append_messages(const Listing& listing, std::vector<RecordedMessage>& messages) const;
  std::shared_ptr<const ChunkCache::Bytes> unpacked_chunk(std::uint32_t number) const;
  std::vector<std::uint8_t> read_plain(const RecordedMessage& message, std::uint64_t most_bytes) const;
  std::vector<std::uint8_t> read_packed(const RecordedMessage& message, std::uint64_t most_bytes) const;
  void require_message(const BagFields& fields, const RecordedMessage& message, std::string_view where) const;

  BagFile file_;
  std::uint32_t connection_count_ = 0;  ///< as the file's beginning says
  std::uint32_t chunk_count_ = 0;
  std::vector<BagConnection> connections_;
  std::vector<Chunk> chunks_;
  std::vector<Listing> listings_;  ///< by connection
  ChunkCache unpacked_;
};

}  // namespace knuckle
