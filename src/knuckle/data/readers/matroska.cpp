// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/matroska.h"

#include <algorithm>
#include <array>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/text.h"
#include "knuckle/data/readers/byte_cursor.h"
#include "knuckle/storage/deflate.h"

namespace knuckle {
namespace {

// The elements that are read (RFC 9559, RFC 8794).
constexpr EbmlId kEbml = 0x1A45DFA3;
constexpr EbmlId kEbmlReadVersion = 0x42F7;
constexpr EbmlId kDocType = 0x4282;
constexpr EbmlId kDocTypeReadVersion = 0x4285;
constexpr EbmlId kVoid = 0xEC;
constexpr EbmlId kCrc32 = 0xBF;
constexpr EbmlId kSegment = 0x18538067;
constexpr EbmlId kSeekHead = 0x114D9B74;
constexpr EbmlId kInfo = 0x1549A966;
constexpr EbmlId kTimestampScale = 0x2AD7B1;
constexpr EbmlId kTracks = 0x1654AE6B;
constexpr EbmlId kTrackEntry = 0xAE;
constexpr EbmlId kTrackNumber = 0xD7;
constexpr EbmlId kTrackUid = 0x73C5;
constexpr EbmlId kTrackName = 0x536E;
constexpr EbmlId kCodecId = 0x86;
constexpr EbmlId kCodecPrivate = 0x63A2;
constexpr EbmlId kContentEncodings = 0x6D80;
constexpr EbmlId kVideo = 0xE0;
constexpr EbmlId kPixelWidth = 0xB0;
constexpr EbmlId kPixelHeight = 0xBA;
constexpr EbmlId kColourSpace = 0x2EB524;
constexpr EbmlId kCluster = 0x1F43B675;
constexpr EbmlId kClusterTimestamp = 0xE7;
constexpr EbmlId kSimpleBlock = 0xA3;
constexpr EbmlId kBlockGroup = 0xA0;
constexpr EbmlId kBlock = 0xA1;
constexpr EbmlId kEncryptedBlock = 0xAF;
constexpr EbmlId kCues = 0x1C53BB6B;
constexpr EbmlId kChapters = 0x1043A770;
constexpr EbmlId kAttachments = 0x1941A469;
constexpr EbmlId kAttachedFile = 0x61A7;
constexpr EbmlId kFileName = 0x466E;
constexpr EbmlId kFileData = 0x465C;
constexpr EbmlId kTags = 0x1254C367;
constexpr EbmlId kTag = 0x7373;
constexpr EbmlId kTargets = 0x63C0;
constexpr EbmlId kTagTrackUid = 0x63C5;
constexpr EbmlId kSimpleTag = 0x67C8;
constexpr EbmlId kTagName = 0x45A3;
constexpr EbmlId kTagString = 0x4487;

/// A cluster of unknown size ends where one of these begins.
constexpr std::array kInSegment{kSeekHead, kInfo, kTracks, kCluster, kCues, kChapters, kAttachments, kTags};

constexpr std::uint64_t kReadVersion = 1;     ///< of EBML
constexpr std::uint64_t kReadDocVersion = 4;  ///< of Matroska
constexpr std::uint64_t kMostTickNs = 1'000'000'000;
constexpr std::int64_t kMostTicks = std::int64_t{1} << 53;
constexpr std::int64_t kMostTimeNs = std::int64_t{1} << 62;

/// As much of a name or a code as anybody looks at.
std::span<const std::uint8_t> start_of(std::span<const std::uint8_t> content) {
  return content.first(std::min(content.size(), static_cast<std::size_t>(limits::kNameLength)));
}

MatroskaTrack parse_track(std::span<const std::uint8_t> entry, std::string_view where) {
  MatroskaTrack track;
  EbmlCursor fields(entry, where);
  while (const auto field = fields.next()) {
    if (field->id == kTrackNumber) track.number = ebml_u64(field->content, where);
    if (field->id == kTrackUid) track.uid = ebml_u64(field->content, where);
    if (field->id == kTrackName) track.name = ebml_text(start_of(field->content));
    if (field->id == kCodecId) track.codec = ebml_text(start_of(field->content));
    if (field->id == kCodecPrivate) {
      const std::span<const std::uint8_t> start = start_of(field->content);
      track.codec_private.assign(start.begin(), start.end());
    }
    if (field->id == kContentEncodings) track.is_encoded = true;
    if (field->id != kVideo) continue;
    EbmlCursor video(field->content, where);
    while (const auto property = video.next()) {
      if (property->id == kPixelWidth) track.width = ebml_u64(property->content, where);
      if (property->id == kPixelHeight) track.height = ebml_u64(property->content, where);
      if (property->id == kColourSpace) {
        const std::span<const std::uint8_t> start = start_of(property->content);
        track.colour_space = {start.begin(), start.end()};
      }
    }
  }
  return track;
}

MatroskaTag parse_simple_tag(std::span<const std::uint8_t> content, std::string_view where) {
  MatroskaTag tag;
  EbmlCursor fields(content, where);
  while (const auto field = fields.next()) {
    if (field->id == kTagName) tag.name = ebml_text(field->content);
    if (field->id == kTagString) tag.value = ebml_text(field->content);
  }
  return tag;
}

std::optional<std::uint64_t> parse_track_uid(std::span<const std::uint8_t> targets, std::string_view where) {
  std::optional<std::uint64_t> uid;
  EbmlCursor fields(targets, where);
  while (const auto field = fields.next()) {
    if (field->id == kTagTrackUid) uid = ebml_u64(field->content, where);
  }
  return uid == 0u ? std::nullopt : uid;  // 0: of all tracks
}

}  // namespace

void Matroska::append_tags(Bytes content, std::string_view where) {
  std::optional<std::uint64_t> uid;
  EbmlCursor fields(content, where);
  while (const auto field = fields.next()) {
    if (field->id == kTargets) uid = parse_track_uid(field->content, where);
    if (field->id != kSimpleTag) continue;
    require_below(tags_.size(), limits::kRecordingTags, "tags");
    tags_.push_back(parse_simple_tag(field->content, where));
    tags_.back().track_uid = uid;
  }
}

Matroska::Matroska(std::filesystem::path path) : file_(std::move(path)) {
  std::uint64_t at = read_header();
  bool has_segment = false;
  while (at < file_.size()) {
    const Element element = element_at(at, file_.size());
    if (element.id == kSegment && has_segment)
      fail("{}: has several segments, expected one", file_.path().string());
    if (element.id == kSegment) read_segment(element);
    has_segment = has_segment || element.id == kSegment;
    at = element.end;
  }
  if (!has_segment) fail("{}: is cut short: it has no segment", file_.path().string());
}

void Matroska::require_below(std::uint64_t count, std::uint64_t most, std::string_view what) const {
  if (count >= most) fail("{}: has more than {} {}", file_.path().string(), most, what);
}

/// The first bytes of an element. Where one follows closely on another the bytes of many are read together;
/// between images, which are far apart, a few.
Matroska::Bytes Matroska::start_at(std::uint64_t at, std::uint64_t end) {
  constexpr std::uint64_t kNear = 256;
  constexpr std::uint64_t kTogether = 4096;
  const bool is_near = at >= starts_at_ && at - starts_at_ < starts_.size() + kNear;
  const bool is_there = is_near && at + kMostEbmlHeadBytes <= starts_at_ + starts_.size();
  if (!is_there) {
    starts_ = file_.read_up_to(at, is_near ? kTogether : kMostEbmlHeadBytes, file_.size());
    starts_at_ = at;
  }
  const Bytes start = Bytes(starts_).subspan(static_cast<std::size_t>(at - starts_at_));
  return start.first(static_cast<std::size_t>(
      std::min<std::uint64_t>({start.size(), kMostEbmlHeadBytes, at > end ? 0 : end - at})));
}

Matroska::Element Matroska::element_at(std::uint64_t at, std::uint64_t end) {
  require_below(elements_++, limits::kRecordingElements, "elements");
  const std::string where = file_.place(at);
  const EbmlHead head = parse_ebml_head(start_at(at, end), where);
  const std::uint64_t data_at = at + head.head_bytes;
  if (!head.is_size_known) {
    if (head.id != kSegment && head.id != kCluster)
      fail("{}: the file is damaged: an element without a size", where);
    return {head.id, at, data_at, end, false};
  }
  if (head.bytes > end - data_at)
    fail("{}: the file is cut short or damaged: an element ends after byte {}", where, end);
  return {head.id, at, data_at, data_at + head.bytes, true};
}

/// Of an element that describes something; its sum is checked where it has one.
std::vector<std::uint8_t> Matroska::content_of(const Element& element) const {
  constexpr auto kMostBytes = static_cast<std::uint64_t>(limits::kRecordHeaderBytes);
  constexpr std::size_t kSumBytes = 2 + 4;
  const std::uint64_t bytes = element.end - element.data_at;
  if (bytes > kMostBytes) {
    fail("{}: a description has {} bytes, expected at most {}", file_.place(element.at), bytes, kMostBytes);
  }
  std::vector<std::uint8_t> content = file_.read(element.data_at, bytes);
  if (content.size() < kSumBytes || content[0] != kCrc32 || content[1] != (0x80 | 4)) return content;
  const std::uint32_t sum = ByteCursor(Bytes(content).subspan(2), "").u32();
  if (!is_sum(crc32(Bytes(content).subspan(kSumBytes)), sum))
    fail("{}: the file is damaged: the sum of an element is another", file_.place(element.at));
  return content;
}

/// Returns where the next element is.
std::uint64_t Matroska::read_header() {
  const std::string name = file_.path().string();
  const std::vector<std::uint8_t> start = file_.read_up_to(0, sizeof kEbml, file_.size());
  constexpr std::array<std::uint8_t, 4> kMagic{0x1A, 0x45, 0xDF, 0xA3};
  if (!std::ranges::equal(start, kMagic)) fail("{}: is not a Matroska file", name);
  const Element header = element_at(0, file_.size());
  const std::vector<std::uint8_t> content = content_of(header);
  std::string type;
  EbmlCursor fields(content, name);
  while (const auto field = fields.next()) {
    if (field->id == kDocType) type = ebml_text(field->content);
    const bool is_late =
        (field->id == kEbmlReadVersion && ebml_u64(field->content, name) > kReadVersion) ||
        (field->id == kDocTypeReadVersion && ebml_u64(field->content, name) > kReadDocVersion);
    if (is_late) {
      fail("{}: wants a reader of version {} of {}, expected at most {}", name,
           ebml_u64(field->content, name), field->id == kEbmlReadVersion ? "EBML" : "Matroska",
           field->id == kEbmlReadVersion ? kReadVersion : kReadDocVersion);
    }
  }
  if (type != "matroska")
    fail("{}: is a file of the kind '{:.40}', expected matroska", name, printable(type));
  return header.end;
}

void Matroska::read_segment(const Element& segment) {
  std::uint64_t at = segment.data_at;
  while (at < segment.end) {
    const Element element = element_at(at, segment.end);
    at = element.end;
    if (element.id == kInfo) read_info(element);
    if (element.id == kTracks) read_tracks(element);
    if (element.id == kTags) read_tags(element);
    if (element.id == kAttachments) read_attachments(element);
    if (element.id == kCluster) at = read_cluster(element);
  }
}

void Matroska::read_info(const Element& element) {
  const std::string where = file_.place(element.at);
  const std::vector<std::uint8_t> content = content_of(element);
  EbmlCursor fields(content, where);
  while (const auto field = fields.next()) {
    if (field->id != kTimestampScale) continue;
    tick_ns_ = ebml_u64(field->content, where);
    if (tick_ns_ < 1 || tick_ns_ > kMostTickNs)
      fail("{}: times count {} ns, expected 1 to {}", where, tick_ns_, kMostTickNs);
  }
}

void Matroska::read_tracks(const Element& element) {
  const std::string where = file_.place(element.at);
  const std::vector<std::uint8_t> content = content_of(element);
  EbmlCursor entries(content, where);
  while (const auto entry = entries.next()) {
    if (entry->id != kTrackEntry) continue;
    require_below(tracks_.size(), limits::kTracks, "tracks");
    tracks_.push_back(parse_track(entry->content, where));
  }
}

void Matroska::read_tags(const Element& element) {
  const std::string where = file_.place(element.at);
  const std::vector<std::uint8_t> content = content_of(element);
  EbmlCursor tags(content, where);
  while (const auto tag = tags.next()) {
    if (tag->id == kTag) append_tags(tag->content, where);
  }
}

void Matroska::read_attachments(const Element& element) {
  constexpr auto kMostNameBytes = static_cast<std::uint64_t>(limits::kNameLength);
  for (std::uint64_t at = element.data_at; at < element.end;) {
    const Element file = element_at(at, element.end);
    at = file.end;
    if (file.id != kAttachedFile) continue;
    MatroskaAttachment attachment;
    for (std::uint64_t in_file = file.data_at; in_file < file.end;) {
      const Element field = element_at(in_file, file.end);
      in_file = field.end;
      if (field.id == kFileName)
        attachment.name = ebml_text(file_.read_up_to(field.data_at, kMostNameBytes, field.end));
      if (field.id == kFileData) {
        attachment.at = field.data_at;
        attachment.bytes = field.end - field.data_at;
      }
    }
    require_below(attachments_.size(), limits::kRecordingTags, "files within it");
    attachments_.push_back(std::move(attachment));
  }
}

/// Returns where it ends.
std::uint64_t Matroska::read_cluster(const Element& cluster) {
  constexpr std::uint64_t kMostNumberBytes = 8;
  std::uint64_t time = 0;
  std::uint64_t at = cluster.data_at;
  while (at < cluster.end) {
    const Element element = element_at(at, cluster.end);
    if (!cluster.is_size_known && std::ranges::find(kInSegment, element.id) != kInSegment.end()) return at;
    at = element.end;
    if (element.id == kClusterTimestamp) {
      const std::string where = file_.place(element.at);
      time = ebml_u64(file_.read_up_to(element.data_at, kMostNumberBytes + 1, element.end), where);
      if (time > static_cast<std::uint64_t>(kMostTicks))
        fail("{}: the file is damaged: a time of {}", where, time);
    }
    if (element.id == kSimpleBlock) add_block(element, time);
    if (element.id == kEncryptedBlock) has_encrypted_blocks_ = true;
    if (element.id != kBlockGroup) continue;
    for (std::uint64_t in_group = element.data_at; in_group < element.end;) {
      const Element part = element_at(in_group, element.end);
      in_group = part.end;
      if (part.id == kBlock) add_block(part, time);
    }
  }
  return at;
}

void Matroska::add_block(const Element& block, std::uint64_t cluster_time) {
  constexpr std::uint64_t kMostHeadBytes = 8 + 2 + 1;  // track, time after the cluster's, flags
  constexpr std::uint8_t kLacing = 0x06;
  const std::string where = file_.place(block.at);
  const std::vector<std::uint8_t> head = file_.read_up_to(block.data_at, kMostHeadBytes, block.end);
  const EbmlNumber track = parse_ebml_number(head, where);
  ByteCursor cursor(Bytes(head).subspan(track.bytes), where);
  const std::uint8_t high = cursor.u8();
  const auto ticks = static_cast<std::int16_t>(high << 8 | cursor.u8());
  TrackBlocks& blocks = blocks_[track.value];
  blocks.has_lacing = blocks.has_lacing || (cursor.u8() & kLacing) != 0;
  const std::uint64_t data_at = block.data_at + track.bytes + 3;
  require_below(block_count_++, limits::kRecordedMessages, "images");
  blocks.blocks.push_back({data_at, block.end - data_at, static_cast<std::int64_t>(cluster_time) + ticks});
}

std::vector<MatroskaBlock> Matroska::blocks_of(const MatroskaTrack& track) const {
  const std::string name = file_.path().string();
  if (has_encrypted_blocks_) fail("{}: has encrypted blocks, which are not read", name);
  const auto found = blocks_.find(track.number);
  if (found == blocks_.end()) return {};
  if (found->second.has_lacing) {
    fail("{}: the track '{}' has several frames per block (lacing), which is not read", name,
         printable(track.name));
  }
  std::vector<MatroskaBlock> blocks = found->second.blocks;
  const auto tick_ns = static_cast<std::int64_t>(tick_ns_);
  for (MatroskaBlock& block : blocks) {
    if (block.time_ns > kMostTimeNs / tick_ns)
      fail("{}: the file is damaged: a time of {} times {} ns", name, block.time_ns, tick_ns);
    block.time_ns *= tick_ns;
  }
  return blocks;
}

}  // namespace knuckle
