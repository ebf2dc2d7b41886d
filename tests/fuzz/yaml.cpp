// The files that a person writes: robot, cell, scenario; and the model file, which comes back as it was
// written.
#include <filesystem>
#include <string>

#include "config/cell_config.hpp"
#include "config/model_file.hpp"
#include "config/robot_file.hpp"
#include "config/scenario.hpp"
#include "config/yaml_reader.hpp"
#include "tests/fuzz/target.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::fuzz {
namespace {

/// The shipped files, so that one that names them relative to itself finds them, and room for one more.
class ConfigFolder {
 public:
  ConfigFolder() {
    for (const char* name : {"robots", "kuka"})
      std::filesystem::create_directory_symlink(kShipped / name, folder_.path() / name);
  }
  std::filesystem::path write(std::string_view text) const {
    return folder_.write("input.yaml", std::string{text});
  }

 private:
  const std::filesystem::path kShipped = std::filesystem::path(TRUEPOSE_SOURCE_DIR) / "config";
  TempFolder folder_;
};

/// Whether `read` took what it was given. It may refuse it in one way only.
template <typename Read>
bool accepts(Read read) {
  try {
    read();
    return true;
  } catch (const config::ConfigError& error) {
    expect(*error.what() != '\0', "a refusal says why");
    return false;
  }
}

}  // namespace

void yaml(std::string_view input) {
  static const ConfigFolder folder;
  const std::string text{input};
  if (!accepts([&] { config::parse_yaml(text, "input.yaml"); })) return;

  const std::filesystem::path file = folder.write(text);
  accepts([&] { config::load_robot(file); });
  accepts([&] { config::load_body(file); });
  accepts([&] { config::load_cell(file); });
  accepts([&] { config::load_scenario(file); });
  std::string written;
  if (!accepts([&] { written = config::model_yaml(config::parse_model(text, "input.yaml")); })) return;
  expect(accepts([&] {
           expect(config::model_yaml(config::parse_model(written, "written.yaml")) == written,
                  "a model comes back as it was written");
         }),
         "a model that is written can be read: " + written);
}

}  // namespace truepose::fuzz
