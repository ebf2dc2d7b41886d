#pragma once

#include <string>

#include "proto/record/frame_document.hpp"

namespace truepose::tools {

/// A measured tool or base for people: the frame with its sigmas, each reading, the controller's statement.
std::string frame_text(const record::FrameDocument& document);

}  // namespace truepose::tools
