// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/model_file.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/regular_file.h"
#include "knuckle/storage/content_hash.h"
#include "knuckle/storage/deflate.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/zip_archive.h"

namespace knuckle {
namespace {

using Json = nlohmann::json;

static_assert(std::endian::native == std::endian::little, "arrays lie in files as they lie in memory");

constexpr std::string_view kHeaderEntry = "model.json";
constexpr std::string_view kSumMark = "knuckle-sum ";
constexpr std::size_t kSumDigits = 16;
constexpr std::size_t kMostDimensions = 8;

template <class T>
constexpr std::string_view kTypeName = "";
template <>
constexpr std::string_view kTypeName<float> = "float32";
template <>
constexpr std::string_view kTypeName<double> = "float64";
template <>
constexpr std::string_view kTypeName<std::int8_t> = "int8";
template <>
constexpr std::string_view kTypeName<std::uint8_t> = "uint8";
template <>
constexpr std::string_view kTypeName<std::int16_t> = "int16";
template <>
constexpr std::string_view kTypeName<std::uint16_t> = "uint16";
template <>
constexpr std::string_view kTypeName<std::int32_t> = "int32";
template <>
constexpr std::string_view kTypeName<std::uint32_t> = "uint32";
template <>
constexpr std::string_view kTypeName<std::int64_t> = "int64";
template <>
constexpr std::string_view kTypeName<std::uint64_t> = "uint64";

/// Bytes of a number of that type; nothing where there is no such type.
std::optional<std::uint64_t> bytes_per_number(std::string_view type) {
  if (type == "int8" || type == "uint8") return 1;
  if (type == "int16" || type == "uint16") return 2;
  if (type == "int32" || type == "uint32" || type == "float32") return 4;
  if (type == "int64" || type == "uint64" || type == "float64") return 8;
  return std::nullopt;
}

/// The header; nothing below the depth of a shape is kept. Discarded where it is not JSON.
Json parsed_header(std::span<const std::uint8_t> text) {
  constexpr int kDepth = 4;
  const auto keep = [](int depth, Json::parse_event_t /*event*/, Json& /*parsed*/) {
    return depth <= kDepth;
  };
  return Json::parse(text.begin(), text.end(), keep, /*allow_exceptions=*/false);
}

std::span<const std::uint8_t> as_bytes(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// The matrix of `rows` x `columns` bytes, its columns as rows.
std::vector<std::uint8_t> transposed(std::span<const std::uint8_t> bytes, std::size_t rows,
                                     std::size_t columns) {
  std::vector<std::uint8_t> result(bytes.size());
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      result[column * rows + row] = bytes[row * columns + column];
    }
  }
  return result;
}

/// The sum of a file: of all bytes before its last 16, as 16 digits.
std::string sum_of(std::span<const std::uint8_t> bytes) {
  return fmt::format("{:08x}{:08x}", crc32(bytes), adler32(bytes));
}

/// Says what a file without a sum is. One of 0.1 is an HDF5 file or LibTorch's archive.
[[noreturn]] void fail_without_sum(std::string_view bytes, const std::string& origin) {
  const auto start = bytes.substr(0, 1 << 16);
  const bool is_hdf5 = start.starts_with("\x89HDF\r\n\x1a\n");
  const bool is_torch = start.starts_with("PK\x03\x04") && start.find("/data.pkl") != std::string_view::npos;
  if (is_hdf5 || is_torch) {
    fail(
        "{}: {}, not a model's file: those of Knuckle 0.1, which was never released, are no longer read; "
        "take "
        "the models that come with the program, or train or import it again",
        origin, is_hdf5 ? "an HDF5 file" : "an archive of LibTorch (or a training's checkpoint)");
  }
  fail("{}: not a model's file, or cut short: its sum is missing", origin);
}

void check_sum(std::string_view bytes, const std::string& origin) {
  const std::size_t tail = kSumMark.size() + kSumDigits;
  if (bytes.size() < tail || !bytes.substr(bytes.size() - tail).starts_with(kSumMark)) {
    fail_without_sum(bytes, origin);
  }
  const std::string_view found = bytes.substr(bytes.size() - kSumDigits);
  if (sum_of(as_bytes(bytes.substr(0, bytes.size() - kSumDigits))) != found) {
    fail("{}: damaged: its content does not have the sum that it says; copy it again", origin);
  }
}

}  // namespace

ModelWriter::ModelWriter(std::string_view format, int version) : format_(format), version_(version) {}

void ModelWriter::set(std::string_view name, std::string_view text) {
  values_.insert_or_assign(std::string(name), std::string(text));
}

void ModelWriter::set(std::string_view name, double number) {
  values_.insert_or_assign(std::string(name), number);
}

void ModelWriter::set(std::string_view name, const std::vector<std::string>& texts) {
  values_.insert_or_assign(std::string(name), texts);
}

void ModelWriter::remove(std::string_view name) {
  values_.erase(std::string(name));
  arrays_.erase(std::string(name));
}

void ModelWriter::set_format(std::string_view format, int version) {
  format_ = format;
  version_ = version;
}

bool ModelWriter::Array::is_shuffled() const {
  return storage == Storage::compact && bytes_per_number(type) != 1;
}

template <class T>
void ModelWriter::add(std::string_view name, const std::vector<std::uint64_t>& shape,
                      std::span<const T> values, Storage storage) {
  const std::span<const std::byte> bytes = std::as_bytes(values);
  Array array{std::string(kTypeName<T>), shape, std::vector<std::uint8_t>(bytes.size()), storage};
  if (!bytes.empty()) std::memcpy(array.bytes.data(), bytes.data(), bytes.size());
  if (array.is_shuffled()) array.bytes = transposed(array.bytes, bytes.size() / sizeof(T), sizeof(T));
  arrays_.insert_or_assign(std::string(name), std::move(array));
}

std::string ModelWriter::header() const {
  Json header = {
      {"format", format_}, {"version", version_}, {"values", Json::object()}, {"arrays", Json::object()}};
  for (const auto& [name, value] : values_) {
    std::visit([&, &key = name](const auto& content) { header["values"][key] = content; }, value);
  }
  for (const auto& [name, array] : arrays_) {
    header["arrays"][name] = {{"type", array.type}, {"shape", array.shape}};
    if (array.is_shuffled()) header["arrays"][name]["shuffled"] = true;
  }
  return header.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string ModelWriter::content_hash() const {
  std::string content = header();
  for (const auto& [name, array] : arrays_) content.append(array.bytes.begin(), array.bytes.end());
  return text_hash(content);
}

std::vector<std::uint8_t> ModelWriter::bytes() const {
  const std::string json = header();
  std::vector<ZipContent> contents{{std::string(kHeaderEntry), as_bytes(json), true}};
  for (const auto& [name, array] : arrays_) {
    contents.push_back({name, array.bytes, array.storage == Storage::compact});
  }
  std::vector<std::uint8_t> bytes = zip_of(contents, std::string(kSumMark) + std::string(kSumDigits, '0'));
  const std::string sum = sum_of(std::span(bytes).first(bytes.size() - kSumDigits));
  std::ranges::copy(sum, bytes.end() - kSumDigits);
  return bytes;
}

void ModelWriter::save(const std::filesystem::path& path) const {
  const std::vector<std::uint8_t> content = bytes();
  if (std::ssize(content) > limits::kModelBytes) {
    fail("{}: a model of {} bytes, at most {} can be read again", path.string(), content.size(),
         limits::kModelBytes);
  }
  write_text_file(path, {reinterpret_cast<const char*>(content.data()), content.size()});
}

/// A file's bytes and what was found in them.
struct ModelFile::Content {
  struct Array {
    std::string type;
    std::vector<std::uint64_t> shape;
    bool is_shuffled = false;
    ZipEntry entry;
  };

  std::string bytes;
  std::string origin;
  std::string format;
  std::int64_t version = 0;
  Json values;
  std::map<std::string, Array, std::less<>> arrays;

  [[noreturn]] void damaged(std::string_view why) const { fail("{}: damaged: {}", origin, why); }

  void read_header(const ZipEntry& entry);
  void read_arrays(const Json& header, std::span<const ZipEntry> entries);
  Array array_of(const std::string& name, const Json& description, const ZipEntry& entry) const;
  const Json& value(std::string_view name) const;
  const Array& array(std::string_view name) const;
  void read(const Array& array, std::span<std::uint8_t> numbers) const;
};

ModelFile::Content::Array ModelFile::Content::array_of(const std::string& name, const Json& description,
                                                       const ZipEntry& entry) const {
  const bool is_sound = description.is_object() && description.contains("type") &&
                        description["type"].is_string() && description.contains("shape") &&
                        description["shape"].is_array() && description["shape"].size() <= kMostDimensions;
  if (!is_sound) damaged(fmt::format("{} has no type and shape", name));
  Array array{
      description["type"].get<std::string>(), {}, description.value("shuffled", Json()) == true, entry};
  const std::optional<std::uint64_t> number_bytes = bytes_per_number(array.type);
  if (!number_bytes) damaged(fmt::format("{} has numbers of an unknown type", name));
  // All sides of at least 1 divide the size: no product can overflow.
  std::uint64_t size = *number_bytes;
  for (const Json& side : description["shape"]) {
    if (!side.is_number_unsigned()) damaged(fmt::format("the shape of {} is not one of whole numbers", name));
    array.shape.push_back(side.get<std::uint64_t>());
    const std::uint64_t length = array.shape.back();
    if (length > static_cast<std::uint64_t>(limits::kModelBytes) ||
        size * length > static_cast<std::uint64_t>(limits::kModelBytes)) {
      damaged(fmt::format("{} has more numbers than a model may have", name));
    }
    size *= length;
  }
  if (size != entry.size) {
    damaged(fmt::format("{} has {} bytes, expected {} by its shape", name, entry.size, size));
  }
  return array;
}

void ModelFile::Content::read_arrays(const Json& header, std::span<const ZipEntry> entries) {
  const Json& described = header["arrays"];
  if (described.size() != entries.size()) {
    damaged(fmt::format("it has {} arrays and describes {}", entries.size(), described.size()));
  }
  for (const ZipEntry& entry : entries) {
    const auto found = described.find(entry.name);
    if (found == described.end()) damaged(fmt::format("its array {} is not described", entry.name));
    arrays.emplace(entry.name, array_of(entry.name, *found, entry));
  }
}

ModelFile::ModelFile(std::unique_ptr<Content> content) : content_(std::move(content)) {}
ModelFile::ModelFile(ModelFile&&) noexcept = default;
ModelFile& ModelFile::operator=(ModelFile&&) noexcept = default;
ModelFile::~ModelFile() = default;

ModelFile ModelFile::open(const std::filesystem::path& path) {
  return parse(read_regular_file(path, limits::kModelBytes), path.string());
}

ModelFile ModelFile::parse(std::string bytes, const std::string& origin) {
  auto content = std::make_unique<Content>();
  content->bytes = std::move(bytes);
  content->origin = origin;
  check_sum(content->bytes, origin);
  const ZipArchive archive = parse_zip(as_bytes(content->bytes), origin);
  if (archive.entries.empty() || archive.entries[0].name != kHeaderEntry) {
    fail("{}: not a model's file: it has no {}", origin, kHeaderEntry);
  }
  if (archive.entries[0].size > static_cast<std::uint64_t>(limits::kModelHeaderBytes)) {
    content->damaged("its header is too long");
  }
  const std::vector<std::uint8_t> text = content_of(archive.entries[0], origin);
  Json header = parsed_header(text);
  const bool is_sound = header.is_object() && header.contains("format") && header["format"].is_string() &&
                        header.contains("version") && header["version"].is_number_integer() &&
                        header.contains("values") && header["values"].is_object() &&
                        header.contains("arrays") && header["arrays"].is_object();
  if (!is_sound) content->damaged("its header is not one of a model");
  content->format = header["format"].get<std::string>();
  content->version = header["version"].get<std::int64_t>();
  content->read_arrays(header, std::span(archive.entries).subspan(1));
  content->values = std::move(header["values"]);
  return ModelFile(std::move(content));
}

const std::string& ModelFile::origin() const {
  return content_->origin;
}

const std::string& ModelFile::format() const {
  return content_->format;
}

void ModelFile::require_format(std::string_view format, int version) const {
  if (content_->format != format) {
    fail("{}: expected a {} file, found a {} file", origin(), format, content_->format);
  }
  if (content_->version != version) {
    fail("{}: version {} of the format {}, expected version {}", origin(), content_->version, format,
         version);
  }
}

const Json& ModelFile::Content::value(std::string_view name) const {
  const auto found = values.find(name);
  if (found == values.end()) fail("{}: {} is missing", origin, name);
  return *found;
}

const ModelFile::Content::Array& ModelFile::Content::array(std::string_view name) const {
  const auto found = arrays.find(name);
  if (found == arrays.end()) fail("{}: {}: the array is missing", origin, name);
  return found->second;
}

bool ModelFile::has(std::string_view name) const {
  return content_->arrays.contains(name) || content_->values.contains(name);
}

std::string ModelFile::text(std::string_view name) const {
  const Json& value = content_->value(name);
  if (!value.is_string()) fail("{}: {} is not a text", origin(), name);
  return value.get<std::string>();
}

double ModelFile::number(std::string_view name) const {
  const Json& value = content_->value(name);
  if (!value.is_number()) fail("{}: {} is not a number", origin(), name);
  return value.get<double>();
}

int ModelFile::integer(std::string_view name, int lowest, int highest) const {
  const double value = number(name);
  if (!(value >= lowest && value <= highest && value == std::floor(value))) {
    fail("{}: {} is {}, expected a whole number from {} to {}", origin(), name, value, lowest, highest);
  }
  return static_cast<int>(value);
}

std::vector<std::string> ModelFile::texts(std::string_view name) const {
  const Json& value = content_->value(name);
  if (!value.is_array()) fail("{}: {} is not a list of texts", origin(), name);
  std::vector<std::string> texts;
  for (const Json& text : value) {
    if (!text.is_string()) fail("{}: {} is not a list of texts", origin(), name);
    texts.push_back(text.get<std::string>());
    if (std::ssize(texts.back()) > limits::kNameLength) {
      fail("{}: a text of {} has {} characters, expected at most {}", origin(), name, texts.back().size(),
           limits::kNameLength);
    }
  }
  return texts;
}

const std::vector<std::uint64_t>& ModelFile::shape(std::string_view name) const {
  return content_->array(name).shape;
}

/// Its numbers as they lie in memory.
void ModelFile::Content::read(const Array& array, std::span<std::uint8_t> numbers) const {
  if (!array.is_shuffled) {
    read_content(array.entry, numbers, origin);
    return;
  }
  const std::vector<std::uint8_t> content = content_of(array.entry, origin);
  const std::size_t width = *bytes_per_number(array.type);
  std::ranges::copy(transposed(content, width, content.size() / width), numbers.begin());
}

template <class T>
ModelArray<T> ModelFile::read(std::string_view name) const {
  const Content::Array& array = content_->array(name);
  if (array.type != kTypeName<T>) {
    fail("{}: {} has numbers of the type {}, expected {}", origin(), name, array.type, kTypeName<T>);
  }
  ModelArray<T> result{array.shape, std::vector<T>(static_cast<std::size_t>(array.entry.size) / sizeof(T))};
  content_->read(array,
                 {reinterpret_cast<std::uint8_t*>(result.values.data()), sizeof(T) * result.values.size()});
  return result;
}

ModelWriter ModelFile::writer() const {
  ModelWriter writer(content_->format, static_cast<int>(content_->version));
  for (const auto& [name, value] : content_->values.items()) {
    if (value.is_string()) {
      writer.set(name, text(name));
    } else if (value.is_number()) {
      writer.set(name, number(name));
    } else {
      writer.set(name, texts(name));
    }
  }
  for (const auto& [name, array] : content_->arrays) {
    const bool is_compact = array.is_shuffled || array.entry.is_deflated;
    writer.arrays_.insert_or_assign(
        name, ModelWriter::Array{array.type, array.shape, content_of(array.entry, origin()),
                                 is_compact ? ModelWriter::Storage::compact : ModelWriter::Storage::plain});
  }
  return writer;
}

#define KNUCKLE_MODEL_TYPE(T)                                                                             \
  template void ModelWriter::add(std::string_view, const std::vector<std::uint64_t>&, std::span<const T>, \
                                 Storage);                                                                \
  template ModelArray<T> ModelFile::read(std::string_view) const
KNUCKLE_MODEL_TYPE(float);
KNUCKLE_MODEL_TYPE(double);
KNUCKLE_MODEL_TYPE(std::int8_t);
KNUCKLE_MODEL_TYPE(std::uint8_t);
KNUCKLE_MODEL_TYPE(std::int16_t);
KNUCKLE_MODEL_TYPE(std::uint16_t);
KNUCKLE_MODEL_TYPE(std::int32_t);
KNUCKLE_MODEL_TYPE(std::uint32_t);
KNUCKLE_MODEL_TYPE(std::int64_t);
KNUCKLE_MODEL_TYPE(std::uint64_t);
#undef KNUCKLE_MODEL_TYPE

}  // namespace knuckle
