// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "knuckle/net/onnx/onnx_model.h"

namespace knuckle {

/// Reads the bytes of an ONNX file, which may be hostile: each length is compared with what is there before
/// memory is taken. What it says is copied, not judged (check_onnx does that). Throws an Error that starts
/// with `origin` where the bytes are no ONNX, or ask for what we do not read: other types than float32 and
/// int64, data in other files, functions, operators of other makers, graphs within graphs.
OnnxModel parse_onnx(std::string_view bytes, const std::string& origin);

/// The same of a file. Throws an Error that names it, also where it is larger than limits::kModelBytes.
OnnxModel load_onnx(const std::filesystem::path& path);

/// The model as the bytes of a file: the same model makes the same bytes.
std::string onnx_bytes(const OnnxModel& model);

}  // namespace knuckle
