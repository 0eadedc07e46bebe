// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/archive.h"

#include <fstream>

#include <torch/utils.h>

#include "knuckle/core/error.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {

ArchiveWriter::ArchiveWriter(std::string_view format, int version) {
  write("format", std::string(format));
  write("version", version);
}

void ArchiveWriter::write(const std::string& name, const std::string& text) {
  archive_.write(name, c10::IValue(text));
}

void ArchiveWriter::write(const std::string& name, double number) {
  archive_.write(name, c10::IValue(number));
}

void ArchiveWriter::write(const std::string& name, const std::vector<torch::Tensor>& tensors) {
  write(name + "_count", static_cast<double>(tensors.size()));
  for (std::size_t i = 0; i < tensors.size(); ++i) {
    // A tensor's archive keeps its whole storage: a copy keeps no more than the values.
    archive_.write(name + "_" + std::to_string(i), tensors[i].detach().cpu().contiguous().clone());
  }
}

void ArchiveWriter::save(const std::filesystem::path& path) {
  save_archive(path, archive_);
}

void save_archive(const std::filesystem::path& path, torch::serialize::OutputArchive& archive) {
  write_file_atomically(path, [&](const std::filesystem::path& temporary) {
    std::ofstream stream(temporary, std::ios::binary);
    // Not by the path: LibTorch would put the temporary name into the file. Nor does it learn that a write
    // failed: it would end the program.
    with_clear_errors(path.string() + ": cannot write", [&] {
      archive.save_to([&](const void* bytes, std::size_t size) {
        stream.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(size));
        return size;
      });
    });
    stream.close();
    if (!stream) fail("{}: cannot write; is the disk full?", path.string());
  });
}

ArchiveReader::ArchiveReader(const std::filesystem::path& path, std::string_view format, int version)
    : path_(path.string()) {
  if (!std::filesystem::is_regular_file(path)) fail("{}: cannot read: no such file", path_);
  try {
    archive_.load_from(path_);
  } catch (const std::exception&) {
    fail("{}: no {} file, or cut short: it is no LibTorch archive that is whole", path_, format);
  }
  c10::IValue found;
  if (!archive_.try_read("format", found) || !found.isString() || found.toStringRef() != format) {
    fail("{}: a LibTorch archive, but none of the format {}", path_, format);
  }
  if (const double written = number("version"); written != version) {
    fail("{}: version {} of the format {}, expected {}", path_, written, format, version);
  }
}

c10::IValue ArchiveReader::value(const std::string& name) {
  c10::IValue value;
  const bool is_there =
      with_clear_errors(path_ + ": " + name, [&] { return archive_.try_read(name, value); });
  if (!is_there) fail("{}: {} is missing", path_, name);
  return value;
}

std::string ArchiveReader::text(const std::string& name) {
  const c10::IValue found = value(name);
  if (!found.isString()) fail("{}: {} is not text", path_, name);
  return found.toStringRef();
}

double ArchiveReader::number(const std::string& name) {
  const c10::IValue found = value(name);
  if (!found.isDouble()) fail("{}: {} is not a number", path_, name);
  return found.toDouble();
}

std::vector<torch::Tensor> ArchiveReader::tensors(const std::string& name) {
  const double count = number(name + "_count");
  if (!(count >= 0 && count <= 1e5)) fail("{}: {} holds {} tensors", path_, name, count);
  std::vector<torch::Tensor> tensors;
  for (int i = 0; i < static_cast<int>(count); ++i) {
    const c10::IValue found = value(name + "_" + std::to_string(i));
    if (!found.isTensor()) fail("{}: {}_{} is not a tensor", path_, name, i);
    tensors.push_back(found.toTensor());
  }
  return tensors;
}

void ArchiveReader::copy_into(const std::string& name, const std::vector<torch::Tensor>& targets) {
  const torch::NoGradGuard no_gradient;
  const std::vector<torch::Tensor> found = tensors(name);
  if (found.size() != targets.size()) {
    fail("{}: {} holds {} tensors, expected {}", path_, name, found.size(), targets.size());
  }
  for (std::size_t i = 0; i < targets.size(); ++i) {
    if (found[i].sizes() != targets[i].sizes())
      fail("{}: {} {} has another shape than expected", path_, name, i);
    const torch::Tensor values = found[i].to(targets[i].scalar_type());
    if (!torch::isfinite(values).all().item<bool>())
      fail("{}: a value of {} {} is not finite", path_, name, i);
    targets[i].detach().copy_(values);
  }
}

}  // namespace knuckle
