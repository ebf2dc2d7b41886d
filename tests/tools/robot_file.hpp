#pragma once

#include <string>

namespace truepose {

/// The KR 210 R2700-2 as the project ships it.
inline const std::string kRobot = std::string(TRUEPOSE_SOURCE_DIR) + "/config/robots/kr210_r2700_2.yaml";

}  // namespace truepose
