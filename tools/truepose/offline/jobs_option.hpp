#pragma once

#include "tools/truepose/command_line.hpp"

namespace truepose::tools {

inline Option jobs_option(int& jobs) {
  return {
      "--jobs",
      &jobs,
      "Threads that work at it; the result is the same with any number; default: as many as this PC runs at once",
      {.check = in_range(1, 1024)}};
}

}  // namespace truepose::tools
