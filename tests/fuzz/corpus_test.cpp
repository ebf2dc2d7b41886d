// Every input that is kept in the tree, and all that can be had of it by cutting its end off, without the
// fuzzer.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/fuzz/target.hpp"

namespace truepose::fuzz {
namespace {

struct Target {
  const char* name;
  void (*take)(std::string_view input);
};

class Corpus : public testing::TestWithParam<Target> {};

std::vector<std::filesystem::path> inputs_of(const std::string& target) {
  const std::filesystem::directory_iterator folder{std::string{TRUEPOSE_SOURCE_DIR} + "/tests/fuzz/corpus/" +
                                                   target};
  std::vector<std::filesystem::path> files(begin(folder), end(folder));
  std::ranges::sort(files);
  return files;
}

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST_P(Corpus, BreaksNoPromiseWholeOrCutAnywhere) {
  constexpr std::size_t kCuts = 20;
  const std::vector<std::filesystem::path> files = inputs_of(GetParam().name);
  ASSERT_FALSE(files.empty());
  for (const std::filesystem::path& file : files) {
    const std::string input = bytes_of(file);
    for (std::size_t cut = 1; cut <= kCuts; ++cut) {
      const std::size_t size = input.size() * cut / kCuts;
      SCOPED_TRACE(file.filename().string() + ", the first " + std::to_string(size) + " bytes");
      ASSERT_NO_THROW(GetParam().take(std::string_view{input}.substr(0, size)));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Fuzz, Corpus,
                         testing::Values(Target{"bridge", bridge}, Target{"control", control},
                                         Target{"csv", csv}, Target{"eki", eki}, Target{"emscon", emscon},
                                         Target{"krl", krl}, Target{"krl_interpreter", krl_interpreter},
                                         Target{"recording", recording}, Target{"rsi_config", rsi_config},
                                         Target{"rsi_context", rsi_context}, Target{"rsi_frame", rsi_frame},
                                         Target{"yaml", yaml}),
                         [](const auto& test) { return std::string{test.param.name}; });

}  // namespace
}  // namespace truepose::fuzz
