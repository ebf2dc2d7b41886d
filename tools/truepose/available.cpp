#include <CLI/CLI.hpp>
#include <algorithm>

#include "tools/truepose/offline_commands.hpp"

namespace truepose::tools {

CLI::Validator available(std::vector<std::string_view> values) {
  const std::string all = CLI::detail::join(values, ", ");
  return {[values = std::move(values), all](const std::string& value) -> std::string {
            if (std::ranges::find(values, value) != values.end()) return {};
            return "'" + value + "' is not available in this version (available: " + all + ")";
          },
          "{" + all + "}"};
}

}  // namespace truepose::tools
