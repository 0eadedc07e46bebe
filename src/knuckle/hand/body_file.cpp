// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/body_file.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/storage/model_file.h"

namespace knuckle {
namespace {

constexpr std::string_view kFormat = "knuckle-body";
constexpr int kVersion = 2;

using Shape = std::vector<std::uint64_t>;

/// Variable-length rows laid end to end: row i is entries starts[i] to starts[i + 1].
struct RowStarts {
  std::vector<std::int64_t> starts{0};

  void add(std::size_t length) { starts.push_back(starts.back() + static_cast<std::int64_t>(length)); }
};

std::vector<float> flattened(const std::vector<Eigen::Vector3f>& points) {
  std::vector<float> values;
  values.reserve(3 * points.size());
  for (const Eigen::Vector3f& point : points) values.insert(values.end(), {point.x(), point.y(), point.z()});
  return values;
}

void write_groups(ModelWriter& file, const std::string& name, std::span<const VertexGroup> groups) {
  RowStarts rows;
  std::vector<std::int32_t> vertices;
  std::vector<float> weights;
  for (const VertexGroup& group : groups) {
    rows.add(group.vertices.size());
    vertices.insert(vertices.end(), group.vertices.begin(), group.vertices.end());
    weights.insert(weights.end(), group.weights.begin(), group.weights.end());
  }
  file.add(name + "_starts", {rows.starts.size()}, rows.starts);
  file.add(name + "_vertices", {vertices.size()}, vertices);
  file.add(name + "_weights", {weights.size()}, weights);
}

void write_shapedirs(ModelWriter& file, const std::vector<ShapeDirection>& shapedirs) {
  RowStarts rows;
  std::vector<std::string> names;
  std::vector<std::int32_t> vertices;
  std::vector<Eigen::Vector3f> offsets;
  for (const ShapeDirection& direction : shapedirs) {
    names.push_back(direction.name);
    rows.add(direction.vertices.size());
    vertices.insert(vertices.end(), direction.vertices.begin(), direction.vertices.end());
    offsets.insert(offsets.end(), direction.offsets_mm.begin(), direction.offsets_mm.end());
  }
  file.set("shapedirs_names", names);
  file.add("shapedirs_starts", {rows.starts.size()}, rows.starts);
  file.add("shapedirs_vertices", {vertices.size()}, vertices);
  file.add("shapedirs_offsets", {offsets.size(), 3}, flattened(offsets));
}

/// V x B weights; the file is compressed, zeros cost nothing.
std::vector<float> dense_weights(const Body& body) {
  const std::size_t bone_count = body.names.size();
  std::vector<float> dense(body.weights.size() * bone_count, 0.0f);
  for (std::size_t i = 0; i < body.weights.size(); ++i) {
    for (std::size_t k = 0; k < Body::kBonesPerVertex; ++k) {
      dense[i * bone_count + body.weight_bones[i][k]] += body.weights[i][k];
    }
  }
  return dense;
}

ModelWriter written(const Body& body) {
  ModelWriter file(kFormat, kVersion);
  file.set("unit", "mm");
  std::vector<std::int32_t> faces;
  for (const auto& face : body.faces) faces.insert(faces.end(), face.begin(), face.end());
  std::vector<std::int32_t> sections;
  for (const BodySection& section : body.sections) {
    sections.insert(sections.end(), {section.vertices, section.faces});
  }
  std::vector<std::string> landmark_names;
  landmark_names.reserve(kSupersetSize);
  for (int i = 0; i < kSupersetSize; ++i) landmark_names.emplace_back(name_of(static_cast<Landmark>(i)));

  file.add("v_template", {body.v_template.size(), 3}, flattened(body.v_template));
  file.add("faces", {body.faces.size(), 3}, faces);
  file.add("is_hand", {body.is_hand.size()}, body.is_hand);
  file.add("sections", {body.sections.size(), 2}, sections);
  file.add("weights", {body.weights.size(), body.names.size()}, dense_weights(body));
  file.set("names", body.names);
  file.add("parents", {body.parents.size()}, body.parents);
  write_shapedirs(file, body.shapedirs);
  write_groups(file, "joint_regressor", body.joint_regressor);
  write_groups(file, "landmark_regressor", body.landmark_regressor);
  file.set("landmark_names", landmark_names);
  file.add("landmark_bones", {body.landmark_bones.size()},
           std::vector<std::int32_t>(body.landmark_bones.begin(), body.landmark_bones.end()));
  return file;
}

/// Reads arrays of one file and checks their shapes.
class Reader {
 public:
  explicit Reader(const ModelFile& file) : file_(file) {}

  /// Values of an array whose shape is `expected`; 0 there stands for any length.
  template <class T>
  std::vector<T> read(const std::string& name, const Shape& expected) const {
    const Shape& shape = file_.shape(name);
    bool agrees = shape.size() == expected.size();
    for (std::size_t i = 0; agrees && i < shape.size(); ++i)
      agrees = expected[i] == 0 || shape[i] == expected[i];
    if (!agrees) fault("{} is {}, expected {}", name, text_of(shape), text_of(expected));
    return file_.read<T>(name).values;
  }

  std::vector<std::string> read_texts(const std::string& name) const { return file_.texts(name); }

  std::vector<Eigen::Vector3f> read_points(const std::string& name, std::uint64_t count) const {
    const auto values = read<float>(name, {count, 3});
    std::vector<Eigen::Vector3f> points;
    points.reserve(values.size() / 3);
    for (std::size_t i = 0; i < values.size(); i += 3)
      points.emplace_back(values[i], values[i + 1], values[i + 2]);
    return points;
  }

  /// Where `row_count` rows start in arrays that end with the last start.
  std::vector<std::int64_t> read_starts(const std::string& name, std::uint64_t row_count) const {
    auto starts = read<std::int64_t>(name, {row_count + 1});
    if (starts.front() != 0 || !std::ranges::is_sorted(starts)) fault("{} do not grow from 0", name);
    return starts;
  }

  std::vector<VertexGroup> read_groups(const std::string& name, std::uint64_t count) const {
    const auto starts = read_starts(name + "_starts", count);
    const auto entries = static_cast<std::uint64_t>(starts.back());
    const auto vertices = read_entries<std::int32_t>(name + "_vertices", entries);
    const auto weights = read_entries<float>(name + "_weights", entries);
    std::vector<VertexGroup> groups(count);
    for (std::size_t i = 0; i < count; ++i) {
      groups[i].vertices.assign(vertices.begin() + starts[i], vertices.begin() + starts[i + 1]);
      groups[i].weights.assign(weights.begin() + starts[i], weights.begin() + starts[i + 1]);
    }
    return groups;
  }

  std::vector<ShapeDirection> read_shapedirs() const {
    const auto names = read_texts("shapedirs_names");
    const auto starts = read_starts("shapedirs_starts", names.size());
    const auto entries = static_cast<std::uint64_t>(starts.back());
    const auto vertices = read_entries<std::int32_t>("shapedirs_vertices", entries);
    const auto offsets =
        entries == 0 ? std::vector<Eigen::Vector3f>() : read_points("shapedirs_offsets", entries);
    std::vector<ShapeDirection> shapedirs;
    for (std::size_t i = 0; i < names.size(); ++i) {
      shapedirs.push_back({names[i],
                           {vertices.begin() + starts[i], vertices.begin() + starts[i + 1]},
                           {offsets.begin() + starts[i], offsets.begin() + starts[i + 1]}});
    }
    return shapedirs;
  }

  template <class... Arguments>
  [[noreturn]] void fault(fmt::format_string<Arguments...> format, Arguments&&... arguments) const {
    fail("{}: {}", file_.origin(), fmt::format(format, std::forward<Arguments>(arguments)...));
  }

 private:
  template <class T>
  std::vector<T> read_entries(const std::string& name, std::uint64_t count) const {
    return count == 0 ? std::vector<T>() : read<T>(name, {count});
  }

  static std::string text_of(const Shape& shape) {
    std::string text;
    for (const std::uint64_t length : shape) {
      text += (text.empty() ? "" : " x ") + (length == 0 ? "N" : std::to_string(length));
    }
    return text;
  }

  const ModelFile& file_;
};

void read_mesh(const Reader& reader, Body& body) {
  body.v_template = reader.read_points("v_template", 0);
  const auto corners = reader.read<std::int32_t>("faces", {0, 3});
  for (std::size_t i = 0; i < corners.size(); i += 3)
    body.faces.push_back({corners[i], corners[i + 1], corners[i + 2]});
  body.is_hand = reader.read<std::uint8_t>("is_hand", {body.faces.size()});
  const auto sections = reader.read<std::int32_t>("sections", {0, 2});
  for (std::size_t i = 0; i < sections.size(); i += 2)
    body.sections.push_back({sections[i], sections[i + 1]});
}

/// The V x B weights as up to four bones a vertex, strongest first.
void read_weights(const Reader& reader, Body& body) {
  const std::size_t bone_count = body.names.size();
  const auto dense = reader.read<float>("weights", {body.v_template.size(), bone_count});
  for (std::size_t i = 0; i < body.v_template.size(); ++i) {
    std::vector<std::pair<float, std::int32_t>> weights;
    for (std::size_t b = 0; b < bone_count; ++b) {
      const float weight = dense[i * bone_count + b];
      if (!std::isfinite(weight)) reader.fault("weights of vertex {} are not finite", i);
      if (weight != 0.0f) weights.emplace_back(weight, static_cast<std::int32_t>(b));
    }
    if (weights.size() > Body::kBonesPerVertex) {
      reader.fault("weights of vertex {} name {} bones, expected at most {}", i, weights.size(),
                   Body::kBonesPerVertex);
    }
    std::ranges::stable_sort(weights, [](const auto& a, const auto& b) { return a.first > b.first; });
    weights.resize(Body::kBonesPerVertex, {0.0f, 0});
    body.weights.emplace_back();
    body.weight_bones.emplace_back();
    for (std::size_t k = 0; k < Body::kBonesPerVertex; ++k) {
      std::tie(body.weights.back()[k], body.weight_bones.back()[k]) = weights[k];
    }
  }
}

void read_landmarks(const Reader& reader, Body& body) {
  const auto names = reader.read_texts("landmark_names");
  for (int i = 0; i < kSupersetSize; ++i) {
    const std::string_view expected = name_of(static_cast<Landmark>(i));
    if (names.size() != kSupersetSize || names[i] != expected) {
      reader.fault("landmark_names are not the {} of this version, in their order", kSupersetSize);
    }
  }
  std::ranges::move(reader.read_groups("landmark_regressor", kSupersetSize), body.landmark_regressor.begin());
  std::ranges::copy(reader.read<std::int32_t>("landmark_bones", {kSupersetSize}),
                    body.landmark_bones.begin());
}

}  // namespace

void save_body(const Body& body, const std::filesystem::path& path) {
  check(body, path.string());
  written(body).save(path);
}

std::string body_hash(const Body& body) {
  return written(body).content_hash();
}

Body load_body(const std::filesystem::path& path) {
  return read_body(ModelFile::open(path));
}

Body read_body(const ModelFile& file) {
  file.require_format(kFormat, kVersion);
  const Reader reader(file);
  Body body;
  body.names = reader.read_texts("names");
  body.parents = reader.read<std::int32_t>("parents", {body.names.size()});
  read_mesh(reader, body);
  read_weights(reader, body);
  body.shapedirs = reader.read_shapedirs();
  body.joint_regressor = reader.read_groups("joint_regressor", body.names.size());
  read_landmarks(reader, body);
  check(body, file.origin());
  return body;
}

}  // namespace knuckle
