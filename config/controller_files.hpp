#pragma once

#include <span>
#include <string_view>

namespace truepose {

struct EmbeddedText {
  std::string_view name, text;
};

namespace config {

/// What a KUKA controller loads, as it is shipped: "kuka/krl/truepose_motion.src" and the like.
std::span<const EmbeddedText> controller_files();

}  // namespace config
}  // namespace truepose
