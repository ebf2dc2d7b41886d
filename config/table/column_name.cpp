#include "config/table/column_name.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <span>
#include <utility>

namespace truepose::config {
namespace {

bool is_decimal_digit(char c) { return c >= '0' && c <= '9'; }

std::string lower(std::string_view text) {
  std::string result{text};
  std::ranges::transform(result, result.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

std::string_view trimmed_name(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

/// Without what programs put between the parts of a name.
std::string compact(std::string_view name) {
  std::string result;
  for (const char c : name)
    if (!std::string_view{" _-.:/[]()$#\"'\t"}.contains(c)) result += c;
  return result;
}

/// "q1" of "a1", "joint1"; with any number, 0 included.
std::string joint_name(std::string_view name) {
  constexpr std::array<std::string_view, 7> kBefore{
      "aipos", "axisact", "jointpositions", "jointposition", "actualposition", "actual", "jointstate"};
  constexpr std::array<std::string_view, 14> kFamilies{"q",          "a",        "j",    "jt",        "joint",
                                                       "jointangle", "jointpos", "axis", "axisangle", "achse",
                                                       "achswinkel", "theta",    "th",   "\xCE\xB8"};
  const auto digits = name.find_last_not_of("0123456789") + 1;
  if (digits == name.size() || digits == 0 || name.size() - digits > 2) return {};
  const std::string_view family = name.substr(0, digits), number = name.substr(digits);
  const bool is_known = std::ranges::any_of(kFamilies, [&](std::string_view each) {
    return family == each || std::ranges::any_of(kBefore, [&](std::string_view before) {
             return family.starts_with(before) && family.substr(before.size()) == each;
           });
  });
  if (!is_known || (number.size() > 1 && number[0] == '0')) return {};
  std::string joint = "q";
  return joint += number;
}

/// "x" of "pos_x" and "x_measured"; no name says the tracker's and the robot's own position alike.
std::string coordinate_name(std::string_view name) {
  constexpr std::array<std::string_view, 17> kAround{
      "pos",          "position", "tracker",        "meas", "measured",  "coord",    "coordinate",
      "coordinates",  "point",    "trackerpos",     "smr",  "reflector", "gemessen", "messpunkt",
      "lasertracker", "smrpos",   "trackerposition"};
  for (const char axis : {'x', 'y', 'z'}) {
    if (name.size() == 1 && name[0] == axis) return {axis};
    const bool is_known = std::ranges::any_of(kAround, [&](std::string_view each) {
      return name.size() == each.size() + 1 && ((name.starts_with(each) && name.back() == axis) ||
                                                (name.front() == axis && name.substr(1) == each));
    });
    if (is_known) return {axis};
  }
  return {};
}

/// Names of an orientation that is converted, and of external axes.
std::string other_name(std::string_view name) {
  constexpr std::array<std::string_view, 6> kQuaternion{"q", "quat", "quaternion", "orientation", "rot", "o"};
  constexpr std::array<std::string_view, 4> kExternal{"e", "ext", "externalaxis", "extaxis"};
  for (const char part : {'w', 'x', 'y', 'z'}) {
    if (std::ranges::any_of(kQuaternion,
                            [&](std::string_view each) {
                              return name.starts_with(each) && name.size() == each.size() + 1 &&
                                     name.back() == part;
                            }) &&
        name != "oy")
      return std::string{"q"} + part;
  }
  for (const std::string_view angle : {"roll", "pitch", "yaw", "w", "p", "r", "rx", "ry", "rz"})
    if (name == angle) return std::string{angle};
  const auto digits = name.find_last_not_of("0123456789") + 1;
  const bool is_external =
      digits + 1 == name.size() && std::ranges::find(kExternal, name.substr(0, digits)) != kExternal.end();
  return is_external ? std::string{"e"}.append(name.substr(digits)) : std::string{};
}

std::string name_without_unit(std::string_view header) {
  const std::string name = lower(trimmed_name(header));
  if (is_own_column_name(name)) return name;
  const std::string plain = compact(name);
  for (const auto& find : {joint_name, coordinate_name, other_name})
    if (std::string found = find(plain); !found.empty()) return found;
  return {};
}

/// The name before a unit in brackets at its end, and the unit: "A1", "deg" of "A1 (deg)".
std::pair<std::string_view, std::string> unit_in_brackets(std::string_view header) {
  for (const auto& [open, close] : {std::pair{'(', ')'}, std::pair{'[', ']'}, std::pair{'<', '>'}}) {
    const auto at = header.rfind(open);
    if (!header.ends_with(close) || at == std::string_view::npos || at == 0) continue;
    return {header.substr(0, at), unit_word(header.substr(at + 1, header.size() - at - 2))};
  }
  return {header, {}};
}

/// The same of a unit as the last word: "x_mm", "A1 deg", "X/mm", "x in m".
std::pair<std::string_view, std::string> unit_at_end(std::string_view header) {
  const auto at = header.find_last_of(" _/.,-");
  if (at == std::string_view::npos || at == 0) return {header, {}};
  std::string unit = unit_word(header.substr(at + 1));
  std::string_view name = header.substr(0, at);
  if (const std::string_view in = trimmed_name(name); lower(in).ends_with(" in"))
    name = in.substr(0, in.size() - 3);
  return {name, std::move(unit)};
}

}  // namespace

std::string unit_word(std::string_view word) {
  using Word = std::pair<std::string_view, std::string_view>;
  constexpr std::array kUnits{Word{"deg", "deg"},        Word{"degree", "deg"},     Word{"degrees", "deg"},
                              Word{"grad", "deg"},       Word{"\xC2\xB0", "deg"},   Word{"\xC2\xBA", "deg"},
                              Word{"deg.", "deg"},       Word{"rad", "rad"},        Word{"radian", "rad"},
                              Word{"radians", "rad"},    Word{"mm", "mm"},          Word{"millimeter", "mm"},
                              Word{"millimeters", "mm"}, Word{"millimetre", "mm"},  Word{"millimetres", "mm"},
                              Word{"cm", "cm"},          Word{"centimeter", "cm"},  Word{"centimeters", "cm"},
                              Word{"centimetre", "cm"},  Word{"centimetres", "cm"}, Word{"m", "m"},
                              Word{"meter", "m"},        Word{"meters", "m"},       Word{"metre", "m"},
                              Word{"metres", "m"},       Word{"in", "inch"},        Word{"inch", "inch"},
                              Word{"inches", "inch"},    Word{"zoll", "inch"},      Word{"\"", "inch"}};
  std::string plain = lower(trimmed_name(word));
  if (plain.size() > 2 && std::string_view{"[("}.contains(plain.front()))
    plain = plain.substr(1, plain.size() - 2);
  for (const auto& [unit_name, unit] : kUnits)
    if (plain == unit_name) return std::string{unit};
  return {};
}

ColumnName column_name(std::string_view header) {
  const std::string_view whole = trimmed_name(header);
  if (std::string name = name_without_unit(whole); !name.empty()) return {std::move(name), {}};
  std::string said;
  for (const auto& [name, unit] : {unit_in_brackets(whole), unit_at_end(whole)}) {
    if (unit.empty()) continue;
    if (std::string found = name_without_unit(name); !found.empty()) return {std::move(found), unit};
    said = unit;
  }
  return {{}, said};
}

bool holds_words(std::string_view name) {
  constexpr std::array<std::string_view, 7> kWords{"smr",   "set",       "time",   "point",
                                                   "cycle", "direction", "program"};
  return std::ranges::find(kWords, name) != kWords.end();
}

bool is_key_name(std::string_view header) {
  constexpr std::array<std::string_view, 26> kKeys{
      "point",   "pointname",  "name",      "punkt",  "punktname",  "target",  "targetname",
      "id",      "nr",         "no",        "number", "num",        "index",   "pose",
      "posenr",  "poseid",     "row",       "label",  "objectname", "feature", "collectiongrouppoint",
      "pointid", "posenumber", "messpunkt", "time",   "timestamp"};
  return std::ranges::find(kKeys, compact(lower(trimmed_name(header)))) != kKeys.end();
}

bool may_be_joint(std::string_view header) {
  const std::string name = lower(header);
  return std::ranges::any_of(std::array{"joint", "axis", "achs", "position"},
                             [&](const char* word) { return name.contains(word); });
}

const std::vector<std::string>& own_column_names() {
  static const std::vector<std::string> names{
      "q1",    "x",         "y",    "z",           "smr",          "set",       "sigma",     "excess",
      "time",  "pose",      "dir1", "temp1",       "payload_kg",   "payload_x", "payload_y", "payload_z",
      "a",     "b",         "c",    "sigma_abc",   "point",        "px",        "py",        "pz",
      "cycle", "direction", "cx",   "cy",          "cz",           "ca",        "cb",        "cc",
      "s",     "t",         "e1",   "residual_mm", "residual_deg", "sigma_mm"};
  return names;
}

bool is_own_column_name(std::string_view name) {
  std::string first{name};
  if (name.size() > 1 && is_decimal_digit(name.back()) && name[0] != '0') {
    const auto digits = name.find_last_not_of("0123456789") + 1;
    if (digits == 0 || name[digits] == '0') return false;
    first = std::string{name.substr(0, digits)} + "1";
  }
  return std::ranges::find(own_column_names(), first) != own_column_names().end();
}

}  // namespace truepose::config
