// SPDX-License-Identifier: Apache-2.0
// The texts beside the images of data sets. The images themselves are not opened, but for ICG's, of which
// there is a small one.
#include "fuzz_target.h"

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/data/readers/folder_source.h"
#include "knuckle/data/readers/hands17_source.h"
#include "knuckle/data/readers/icg_source.h"
#include "knuckle/data/readers/icvl_source.h"
#include "knuckle/data/readers/msra15_source.h"

namespace knuckle::fuzz {
namespace {

constexpr std::string_view kDescription =
    "convention = 'icg20'\n[camera]\nwidth = 4\nheight = 3\nfx = 5\nfy = 5\ncx = 2\ncy = 1\n";

/// A kind of set: what lies in its folder beside the text, where the text lies, and who reads it.
struct Kind {
  std::vector<std::pair<std::string_view, std::string_view>> files;
  std::string_view text;
  std::unique_ptr<FrameSource> (*open)(const std::filesystem::path& folder);
};

template <class Source, class... Options>
std::unique_ptr<FrameSource> opened(const std::filesystem::path& folder) {
  return std::make_unique<Source>(folder, Options{}...);
}

std::vector<Kind> kinds() {
  const std::vector<std::pair<std::string_view, std::string_view>> folder{
      {"dataset.toml", kDescription}, {"depth/0.png", ""}, {"depth/1.png", ""}, {"depth/2.png", ""}};
  return {
      {folder, "times.txt", opened<FolderSource>},
      {folder, "sequences.txt", opened<FolderSource>},
      {folder, "joints.txt", opened<FolderSource>},
      {{{"Depth/a.png", ""}}, "labels.txt", opened<IcvlSource, IcvlOptions>},
      {{{"images/a.png", ""}}, "Training_Annotation.txt", opened<Hands17Source, Hands17Options>},
      {{{"P0/1/000000_depth.bin", ""}, {"P0/1/000002_depth.bin", ""}},
       "P0/1/joint.txt",
       opened<Msra15Source>},
      {{{"calib.txt", "200 200\n2 2\n"}, {"1_2_depth.csv", "400,401\n500,501\n"}},
       "1_2_anno_me.txt",
       opened<IcgSource, IcgOptions>},
  };
}

}  // namespace

/// '0': times.txt; '1': sequences.txt; '2': joints.txt; '3': ICVL's labels; '4': HANDS17's; '5': MSRA15's
/// joint.txt; '6': an annotation of ICG's.
void run_set_texts(Bytes bytes) {
  static const std::vector<Kind> all = kinds();
  static const FuzzFolder folders;
  const auto [which, content] = selected(bytes, all.size());
  const Kind& kind = all[which];
  const std::filesystem::path name = std::to_string(which);
  if (!std::filesystem::exists(folders.path() / name)) {
    for (const auto& [file, held] : kind.files) folders.write(name / file, held);
  }
  folders.write(name / kind.text, as_text(content));
  const auto source = kind.open(folders.path() / name);
  for (std::int64_t i = 0; i < std::min<std::int64_t>(source->size(), 3); ++i) (void)source->read_label(i);
}

}  // namespace knuckle::fuzz
