#pragma once

#include <cstddef>
#include <string_view>

namespace truepose::emscon {

/// Why bytes are not an emScon packet.
struct EmsconError {
  std::string_view what;   ///< a constant phrase, e.g. "packet shorter than its layout"
  std::size_t offset = 0;  ///< byte within the packet
};

}  // namespace truepose::emscon
