// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/text.h"
#include "knuckle/export/export_network.h"

namespace knuckle::cli {
namespace {

struct ExportArguments {
  std::filesystem::path model;
  std::filesystem::path out;
};

void run_export(const ExportArguments& arguments) {
  const ExportedFile exported = export_network(arguments.model, arguments.out);
  constexpr double kBytesPerMegabyte = 1e6;
  fmt::print("{}: the network \"{}\", {} operations, {} numbers, {:.1f} MB\n",
             printable(arguments.out.string()), exported.network, exported.nodes, exported.weights,
             static_cast<double>(std::filesystem::file_size(arguments.out)) / kBytesPerMegabyte);
}

}  // namespace

void add_export(CLI::App& program) {
  CLI::App& verb = add_verb(program, "export", "Write a network as ONNX, for other engines",
                            "knuckle export --model models/dense.pt --out dense.onnx");
  auto arguments = std::make_shared<ExportArguments>();
  verb.add_option("--model", arguments->model, "A network's file, as `knuckle train network` writes it")
      ->required();
  verb.add_option("--out", arguments->out, "ONNX file to write")->required();
  verb.callback([arguments] { run_export(*arguments); });
}

}  // namespace knuckle::cli
