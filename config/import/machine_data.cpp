#include "config/import/machine_data.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <string_view>

#include "config/kuka_archive.hpp"
#include "config/number_text.hpp"
#include "config/text_file.hpp"
#include "core/math/angles.hpp"
#include "proto/xml/scanner.hpp"

namespace truepose::config {
namespace {

using xml::trimmed;

std::string in_capitals(std::string_view text) {
  std::string capitals{text};
  std::ranges::transform(capitals, capitals.begin(), [](unsigned char c) { return std::toupper(c); });
  return capitals;
}

/// The assignments of a data list: "$LENGTH_A" to "350.000". Capital letters, without comments.
class MachineData {
 public:
  MachineData(const std::string& text, const std::string& place) : place_{place} {
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      add(std::string_view{text}.substr(at, end - at));
      at = end + 1;
    }
  }

  [[noreturn]] void fail(const std::string& name, const std::string& what) const {
    throw ConfigError{place_ + ": " + name + ": " + what};
  }
  const std::string& text(const std::string& name) const {
    const auto found = values_.find(name);
    if (found == values_.end()) fail(name, "is missing. Give R1/Mada/$machine.dat of an arm with six axes.");
    return found->second;
  }
  double number(const std::string& name) const { return number_in(name, text(name)); }
  /// Of a structure {X 1.0,Y 2.0}.
  double number(const std::string& name, std::string_view member) const {
    std::string_view rest = text(name);
    if (!rest.starts_with('{') || !rest.ends_with('}'))
      fail(name, "expected {" + std::string{member} + " ..}");
    rest = rest.substr(1, rest.size() - 2);
    while (!rest.empty()) {
      const std::size_t comma = std::min(rest.find(','), rest.size());
      const std::string_view each = trimmed(rest.substr(0, comma));
      rest.remove_prefix(std::min(comma + 1, rest.size()));
      const std::size_t blank = each.find(' ');
      if (blank != std::string_view::npos && each.substr(0, blank) == member)
        return number_in(name, std::string{trimmed(each.substr(blank))});
    }
    fail(name, "has no " + std::string{member});
  }
  /// Refuses what the rows of this reader do not describe.
  void expect(const std::string& name, std::string_view member, double value) const {
    const double found = member.empty() ? number(name) : number(name, member);
    if (std::abs(found - value) < 1e-6) return;
    fail(name, (member.empty() ? "" : std::string{member} + " ") + "is " + format_number(found) +
                   ", and only arms with " + format_number(value) +
                   " are known. Import a URDF or a DH table.");
  }
  void expect_word(const std::string& name, std::string_view word) const {
    if (text(name) == word) return;
    fail(name,
         "is " + text(name) + ", and only " + std::string{word} + " is known. Import a URDF or a DH table.");
  }

 private:
  void add(std::string_view line) {
    line = trimmed(line.substr(0, line.find(';')));
    const std::size_t dollar = line.find('$'), equals = line.find('=');
    if (dollar == std::string_view::npos || equals == std::string_view::npos || dollar > equals) return;
    // In front of the name stand at most DECL and a type.
    if (line.substr(0, dollar).find_first_of("{\"'") != std::string_view::npos) return;
    values_.insert_or_assign(in_capitals(trimmed(line.substr(dollar, equals - dollar))),
                             in_capitals(trimmed(line.substr(equals + 1))));
  }
  double number_in(const std::string& name, const std::string& text) const {
    const auto value = xml::to_number<double>(text);
    if (!value) fail(name, "not a number: " + in_quotes(text));
    return *value;
  }

  std::string place_;
  std::map<std::string, std::string> values_;
};

std::string of_axis(const std::string& name, int axis) { return name + "[" + std::to_string(axis) + "]"; }

/// Greatest speed of an axis (deg/s) from its motor's (1/min) and the gear.
double speed_deg(const MachineData& data, int axis) {
  constexpr double kDegPerSecondOfRpm = 6;
  const std::string gear = of_axis("$RAT_MOT_AX", axis);
  const double ratio = data.number(gear, "N") / data.number(gear, "D");
  if (!(std::abs(ratio) > 0)) data.fail(gear, "expected a gear ratio other than 0");
  return std::round(std::abs(data.number(of_axis("$VEL_AXIS_MA", axis)) * kDegPerSecondOfRpm / ratio) *
                    1000) /
         1000;
}

void expect_known_arm(const MachineData& data) {
  data.expect_word("$MAIN_AXIS", "#NR");
  data.expect_word("$WRIST_AXIS", "#ZEH");
  for (const char* frame : {"$TIRORO", "$TFLWP", "$TX3P3"}) {
    data.expect(frame, "Y", 0);
    data.expect(frame, "A", 0);
    data.expect(frame, "C", 0);
  }
  data.expect("$TIRORO", "X", 0);
  data.expect("$TIRORO", "B", 0);
  data.expect("$TFLWP", "X", 0);
  data.expect("$TFLWP", "B", 0);
  data.expect("$TX3P3", "B", 90);
  data.expect("$DH_4", "DHART_ALPHA", 90);
  data.expect("$DH_5", "DHART_ALPHA", -90);
  constexpr std::array kDirections{-1, 1, 1, -1, -1, -1};
  for (int axis = 1; axis <= 6; ++axis)
    data.expect(of_axis("$AXIS_DIR", axis), "", kDirections[static_cast<std::size_t>(axis - 1)]);
}

std::string name_of_arm(const MachineData& data) {
  std::string_view name = trimmed(data.text("$TRAFONAME[]"));
  if (name.size() >= 2 && name.starts_with('"') && name.ends_with('"'))
    name = name.substr(1, name.size() - 2);
  if (name.starts_with('#')) name.remove_prefix(1);
  return "KUKA " + std::string{trimmed(name)};
}

}  // namespace

RobotModel robot_of_machine_data(const std::string& text, const std::string& place) {
  const MachineData data{text, place};
  expect_known_arm(data);
  struct Row {
    double a, alpha_deg, d, theta_deg, sign;
  };
  const std::array<Row, 6> rows{
      Row{0, 0, data.number("$TIRORO", "Z"), 0, -1},
      Row{data.number("$LENGTH_A"), -90, 0, 0, 1},
      Row{data.number("$LENGTH_B"), 0, 0, -90, 1},
      Row{data.number("$TX3P3", "Z"), -90, data.number("$TX3P3", "X"), 0, -1},
      Row{data.number("$DH_4", "DHART_A"), 90, data.number("$DH_4", "DHART_D"), 0, 1},
      Row{data.number("$DH_5", "DHART_A"), -90, data.number("$TFLWP", "Z") + data.number("$DH_5", "DHART_D"),
          180, -1}};
  RobotModel robot;
  robot.name = name_of_arm(data);
  for (int axis = 1; axis <= 6; ++axis) {
    const Row& row = rows[static_cast<std::size_t>(axis - 1)];
    Joint joint{.a_mm = row.a,
                .alpha_rad = row.alpha_deg * kRadPerDeg,
                .d_mm = row.d,
                .theta_rad = row.theta_deg * kRadPerDeg,
                .sign = row.sign,
                .min = data.number(of_axis("$SOFTN_END", axis)) * kRadPerDeg,
                .max = data.number(of_axis("$SOFTP_END", axis)) * kRadPerDeg,
                .speed = speed_deg(data, axis) * kRadPerDeg};
    if (joint.min >= joint.max) data.fail(of_axis("$SOFTN_END", axis), "expected less than $SOFTP_END");
    robot.joints.push_back(joint);
  }
  return robot;
}

RobotModel load_machine_data(const std::filesystem::path& source) {
  const std::string name = in_capitals(source.filename().string());
  if (!std::filesystem::is_directory(source) && !name.ends_with(".ZIP"))
    return robot_of_machine_data(read_bytes(source), source.string());
  std::vector<ArchiveFile> files = read_kuka_archive(source);
  std::erase_if(files, [](const ArchiveFile& file) {
    const std::string path = in_capitals(file.path);
    // STEU has a file of that name too: of the controller, without an arm.
    return (path != "$MACHINE.DAT" && !path.ends_with("MADA/$MACHINE.DAT")) || path.contains("STEU/");
  });
  if (files.empty())
    throw ConfigError{source.string() +
                      ": no R1/Mada/$machine.dat in it. Give the whole archive, or that file."};
  if (files.size() > 1)
    throw ConfigError{source.string() + ": holds " + files[0].path + " and " + files[1].path +
                      ". Give the one of this arm."};
  return robot_of_machine_data(files[0].text, source.string() + "/" + files[0].path);
}

}  // namespace truepose::config
