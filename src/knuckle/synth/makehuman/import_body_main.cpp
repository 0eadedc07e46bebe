// SPDX-License-Identifier: Apache-2.0
// knuckle_import_body PACKAGE_FOLDER BODY.model: MakeHuman's body as the file that is installed. Part of the
// build; not installed.
#include <cstdio>

#include "knuckle/hand/body_file.h"
#include "knuckle/synth/makehuman/makehuman_import.h"

int main(int count, char** arguments) try {
  if (count != 3) return std::fprintf(stderr, "usage: knuckle_import_body PACKAGE_FOLDER BODY.model\n"), 2;
  knuckle::save_body(knuckle::import_makehuman(arguments[1]), arguments[2]);
} catch (const std::exception& error) {
  return std::fprintf(stderr, "knuckle_import_body: %s\n", error.what()), 1;
}
