#pragma once

#include <string_view>

#include "proto/krl/program.hpp"

namespace truepose::krl {

/// Of one program: file 0 is its SRC, 1 its data list, 2 $config.dat. What is empty is not given.
inline ProgramText program_text(std::string_view src, std::string_view dat, std::string_view config) {
  using Role = SourceText::Role;
  return {
      .files = {{Role::Program, "", src}, {Role::Data, "", dat}, {Role::Config, "$CONFIG", config, false}}};
}

}  // namespace truepose::krl
