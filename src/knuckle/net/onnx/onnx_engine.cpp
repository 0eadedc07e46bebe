// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/onnx/onnx_engine.h"

#include <cmath>
#include <filesystem>
#include <utility>

#include <dlfcn.h>

#include "knuckle/core/error.h"
#include "knuckle/core/own_file.h"
#include "knuckle/net/onnx/onnx_engine_library.h"
#include "knuckle/net/onnx/onnx_file.h"

namespace knuckle {
namespace {

namespace fs = std::filesystem;

// From PREFIX/lib/x86_64-linux-gnu/glibc-hwcaps/x86-64-v3, where a processor's own variant of the library
// lies, it is two folders up to where libraries lie.
constexpr int kFoldersAbove = 2;

/// The library beside our own, or in lib/ beside the folder of a program that contains all of us.
fs::path engine_library() {
  fs::path folder = own_file().parent_path();
  std::error_code unknown;
  for (int above = 0; above <= kFoldersAbove; ++above, folder = folder.parent_path()) {
    for (const fs::path& place : {folder, folder / "lib"}) {
      if (fs::is_regular_file(place / kEngineLibrary, unknown)) return place / kEngineLibrary;
    }
  }
  return {};
}

/// The library once it is loaded, which it stays; without a maker, and with the reason, where it cannot be.
struct LoadedLibrary {
  const OnnxEngineMaker* maker = nullptr;
  std::string fault;
};

LoadedLibrary load_engine_library() {
  const fs::path library = engine_library();
  if (library.empty()) {
    return {nullptr,
            fmt::format("this build runs no ONNX files: there is no {} (build Knuckle where OpenCV's dnn, "
                        "libopencv-dnn-dev, is installed)",
                        kEngineLibrary)};
  }
  void* const handle = ::dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr)
    return {nullptr, fmt::format("{} cannot be loaded: {}", library.string(), ::dlerror())};
  const auto function = reinterpret_cast<OnnxEngineFunction>(::dlsym(handle, kEngineFunction));
  if (function == nullptr)
    return {nullptr, fmt::format("{} is of another version of Knuckle", library.string())};
  return {function(), {}};
}

const LoadedLibrary& loaded_library() {
  static const LoadedLibrary library = load_engine_library();
  return library;
}

}  // namespace

OnnxSupport onnx_support() {
  const LoadedLibrary& library = loaded_library();
  if (library.maker == nullptr) return {false, library.fault};
  return {true, library.maker->name};
}

std::unique_ptr<OnnxEngine> create_onnx_engine(const OnnxModel& model, const std::string& origin) {
  const LoadedLibrary& library = loaded_library();
  if (library.maker == nullptr) fail("{}: {}", origin, library.fault);
  try {
    return library.maker->create(onnx_bytes(model), model);
  } catch (const std::runtime_error& error) {
    fail("{}: {} cannot run it: {}", origin, library.maker->name, error.what());
  }
}

}  // namespace knuckle
