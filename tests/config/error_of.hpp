#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "config/text_file.hpp"

namespace truepose::config {

/// What a ConfigError says, with the path of the file cut down to its name; "" where nothing was thrown.
template <typename Load>
std::string error_of(const Load& load, const std::filesystem::path& file) {
  try {
    load();
  } catch (const ConfigError& error) {
    const std::string what = error.what(), folder = file.parent_path().string() + "/";
    return what.starts_with(folder) ? what.substr(folder.size()) : what;
  }
  return "";
}

}  // namespace truepose::config
