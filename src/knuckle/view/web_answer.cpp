// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/text.h"
#include "knuckle/view/web_server.h"

namespace knuckle {

WebAnswer sentence_answer(int status, std::string_view sentence) {
  return {.status = status,
          .content_type = "text/plain; charset=utf-8",
          .body = printable(sentence) + "\n",
          .allow = {}};
}

}  // namespace knuckle
