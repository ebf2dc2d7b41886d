#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/proto/krl_text.hpp"

/// The KRL programs of tests/proto/krl_programs.
namespace truepose::krl_corpus {

inline const std::filesystem::path kFolder = std::string(TRUEPOSE_SOURCE_DIR) + "/tests/proto/krl_programs";

inline std::string bytes(const std::string& name) {
  std::ifstream in(kFolder / name, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

struct Files {
  std::string name, src, dat, config;
  krl::ProgramText text() const { return krl::program_text(src, dat, config); }
};

inline Files files(const std::string& name) {
  return {name, bytes(name + ".src"), bytes(name + ".dat"), bytes("config.dat")};
}

inline std::vector<Files> all() {
  return {files("gluing"), files("handmade"), files("splines"), files("computed")};
}

}  // namespace truepose::krl_corpus
