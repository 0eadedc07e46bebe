// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/data/readers/ebml.h"
#include "knuckle/data/readers/recording_file.h"

namespace knuckle {

/// A track of a Matroska file.
struct MatroskaTrack {
  std::uint64_t number = 0;  ///< by which blocks name it
  std::uint64_t uid = 0;     ///< by which tags name it
  std::string name;          ///< as in "DEPTH"
  std::string codec;         ///< as in "V_MS/VFW/FOURCC"
  std::vector<std::uint8_t> codec_private;
  std::string colour_space;  ///< FourCC of the pixels of V_UNCOMPRESSED
  std::uint64_t width = 0;   ///< [px]
  std::uint64_t height = 0;  ///< [px]
  bool is_encoded = false;   ///< its blocks are compressed or encrypted besides what the codec does
};

/// A name and its value, of the whole file or of a track.
struct MatroskaTag {
  std::optional<std::uint64_t> track_uid;
  std::string name;
  std::string value;
};

/// A file within the file.
struct MatroskaAttachment {
  std::string name;
  std::uint64_t at = 0;  ///< [bytes]
  std::uint64_t bytes = 0;
};

/// One image, or what else a track has.
struct MatroskaBlock {
  std::uint64_t at = 0;      ///< [bytes]
  std::uint64_t bytes = 0;   ///< these lie in the file
  std::int64_t time_ns = 0;  ///< from the beginning of the recording
};

/// A Matroska file (RFC 9559): its tracks, tags, attachments, and where their blocks are. Opening reads the
/// heads of all blocks, and none of their contents; cues are not needed. Safe to be read by many threads.
class Matroska {
 public:
  /// Throws an Error that names the file where it is no Matroska file, of a later version, damaged or cut
  /// short.
  explicit Matroska(std::filesystem::path path);

  const std::filesystem::path& path() const { return file_.path(); }
  const std::vector<MatroskaTrack>& tracks() const { return tracks_; }
  const std::vector<MatroskaTag>& tags() const { return tags_; }
  const std::vector<MatroskaAttachment>& attachments() const { return attachments_; }
  /// The blocks of a track, in the order of the file. Throws an Error where some hold several frames
  /// ("lacing"), or are encrypted.
  std::vector<MatroskaBlock> blocks_of(const MatroskaTrack& track) const;
  /// These bytes of the file. Throws, before memory is taken, where it does not hold them.
  std::vector<std::uint8_t> read(std::uint64_t at, std::uint64_t bytes) const {
    return file_.read(at, bytes);
  }

 private:
  using Bytes = std::span<const std::uint8_t>;

  /// An element of the file.
  struct Element {
    EbmlId id = 0;
    std::uint64_t at = 0;       ///< of its head [bytes]
    std::uint64_t data_at = 0;  ///< of its content
    std::uint64_t end = 0;      ///< of the content; of the parent, where its size is not known
    bool is_size_known = true;
  };
  struct TrackBlocks {
    std::vector<MatroskaBlock> blocks;
    bool has_lacing = false;
  };

  void require_below(std::uint64_t count, std::uint64_t most, std::string_view what) const;
  Bytes start_at(std::uint64_t at, std::uint64_t end);
  Element element_at(std::uint64_t at, std::uint64_t end);
  std::vector<std::uint8_t> content_of(const Element& element) const;
  std::uint64_t read_header();
  void read_segment(const Element& segment);
  void read_info(const Element& element);
  void read_tracks(const Element& element);
  void read_tags(const Element& element);
  void append_tags(Bytes content, std::string_view where);
  void read_attachments(const Element& element);
  std::uint64_t read_cluster(const Element& cluster);
  void add_block(const Element& block, std::uint64_t cluster_time);

  RecordingFile file_;
  std::uint64_t tick_ns_ = 1'000'000;  ///< of all times
  std::vector<MatroskaTrack> tracks_;
  std::vector<MatroskaTag> tags_;
  std::vector<MatroskaAttachment> attachments_;
  std::map<std::uint64_t, TrackBlocks> blocks_;  ///< by the track's number; times in ticks until all is read
  bool has_encrypted_blocks_ = false;
  std::uint64_t elements_ = 0;        ///< that were looked at
  std::uint64_t block_count_ = 0;     ///< of all tracks
  std::vector<std::uint8_t> starts_;  ///< bytes of the file, where elements begin
  std::uint64_t starts_at_ = 0;
};

}  // namespace knuckle
