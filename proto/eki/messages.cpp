#include "proto/eki/messages.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <concepts>
#include <map>
#include <set>
#include <type_traits>
#include <utility>

#include "core/math/angles.hpp"
#include "proto/text/device_text.hpp"
#include "proto/xml/escape.hpp"
#include "proto/xml/scanner.hpp"

namespace truepose::eki {
namespace {

using Names = std::array<std::string_view, 6>;
constexpr Names kAxisNames{"A1", "A2", "A3", "A4", "A5", "A6"};
constexpr Names kPoseNames{"X", "Y", "Z", "A", "B", "C"};
constexpr int kDecimals = 6;  // KRL's REAL has seven digits

Axes scaled(Axes values, double factor) {
  for (double& value : values) value *= factor;
  return values;
}

// ---- writing

/// One element with its children; written as an open and close pair.
class Element {
 public:
  explicit Element(std::string_view name) : name_{name} { text_.append("<").append(name); }

  Element& set(std::string_view name, std::string_view value) {
    text_.append(" ").append(name).append("=\"").append(xml::escaped(value)).append("\"");
    return *this;
  }
  Element& set(std::string_view name, std::integral auto value) { return set(name, std::to_string(+value)); }
  Element& set(const Names& names, const std::array<double, 6>& values) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      std::array<char, 400> digits;  // room for the longest double without exponent
      const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), values[i],
                                     std::chars_format::fixed, kDecimals);
      set(names[i], std::string_view{digits.data(), end.ptr});
    }
    return *this;
  }
  Element& add(const Element& child) {
    children_ += child.str();
    return *this;
  }
  Element& set_if(std::string_view name, std::optional<int> value) {
    return value ? set(name, *value) : *this;
  }
  Element& add_if(bool there, const Element& child) { return there ? add(child) : *this; }
  std::string str() const { return text_ + ">" + children_ + "</" + std::string{name_} + ">"; }

 private:
  std::string_view name_;
  std::string text_;
  std::string children_;
};

Element axes_element(const Axes& axes_rad) {
  return Element{"Ax"}.set(kAxisNames, scaled(axes_rad, kDegPerRad));
}

std::string to_xml(const Command& command) {
  return Element{"Cmd"}
      .set("Id", command.id)
      .set("Type", static_cast<int>(command.type))
      .set("Vel", command.velocity_percent)
      .set("Acc", command.acceleration_percent)
      .set("Settle", command.settle_ms)
      .add(axes_element(command.axes_rad))
      .str();
}

std::string to_xml(const Control& control) {
  return Element{"Ctl"}
      .set("Id", control.id)
      .set("Op", static_cast<int>(control.op))
      .set("Val", control.value)
      .str();
}

std::string to_xml(const Ack& ack) {
  Element element{"Ack"};
  element.set("Id", ack.id).set("State", static_cast<int>(ack.state)).set("Err", ack.error);
  if (ack.axes_rad) element.add(axes_element(*ack.axes_rad));
  return element.str();
}

std::string to_xml(const Hello& hello) {
  return Element{"Hello"}
      .set("Ver", hello.version)
      .set("Model", hello.model)
      .set("Serial", hello.serial)
      .set_if("Tool", hello.tool)
      .set_if("Base", hello.base)
      .set("KssVer", hello.kss_version)
      .str();
}

std::string to_xml(const State& state) {
  return Element{"State"}
      .set("Seq", state.sequence)
      .set("Id", state.id)
      .set("ModeOp", static_cast<int>(state.mode))
      .set("OvPro", state.override_percent)
      .set("ProState", static_cast<int>(state.program))
      .set("PeriRdy", state.drives_ready)
      .set("AlarmStop", state.no_emergency_stop)
      .set("UserSaf", state.gate_closed)
      .set("StopMess", state.stop_message)
      .set("ProMove", state.moving)
      .set("InPos", state.in_position)
      .add(axes_element(state.axes_rad))
      .add(Element{"Pos"}.set(kPoseNames, state.pose))
      .add_if(state.base.has_value(), Element{"Base"}.set_if("No", state.base))
      .add_if(state.tool.has_value(), Element{"Tool"}.set_if("No", state.tool))
      .str();
}

// ---- reading

/// Replaces the entities of XML; empty if there is one that XML does not have.
std::optional<std::string> unescaped(std::string_view text) {
  static constexpr std::array<std::pair<std::string_view, char>, 5> kEntities{
      {{"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}}};
  std::string result;
  while (!text.empty()) {
    if (text.front() != '&') {
      result += text.front();
      text.remove_prefix(1);
      continue;
    }
    const auto* entity =
        std::ranges::find_if(kEntities, [&](const auto& e) { return text.starts_with(e.first); });
    if (entity == kEntities.end()) return std::nullopt;
    result += entity->second;
    text.remove_prefix(entity->first.size());
  }
  return result;
}

bool equal_ignoring_case(std::string_view a, std::string_view b) {
  return std::ranges::equal(
      a, b, [](unsigned char x, unsigned char y) { return std::toupper(x) == std::toupper(y); });
}

/// The attributes of one message by path: "Id" for its own, "Ax.A1" for those of its children. A getter that
/// fails leaves the first error behind and returns zero.
class Fields {
 public:
  explicit Fields(std::string_view name) : name_{name} {}

  /// Takes the attributes of the message itself, or of one of its children.
  void take(const xml::Scanner& scanner, bool is_child) {
    const std::string element = is_child ? std::string{scanner.name()} : "";
    if (is_child && !elements_.insert(scanner.name()).second) return fail(element + " comes twice");
    if (!scanner.has_all_attributes()) return fail(element + " has too many attributes");
    for (const xml::Attribute& attribute : scanner.attributes()) {
      const std::string path = (is_child ? element + "." : "") + std::string{attribute.name};
      if (!values_.emplace(path, attribute.value).second) fail(path + " comes twice");
    }
  }

  std::string_view name() const { return name_; }
  const std::optional<std::string>& error() const { return error_; }

  /// Whether nothing in it has a value.
  bool is_blank() const {
    return !error_ &&
           std::ranges::all_of(values_, [](const auto& v) { return xml::trimmed(v.second).empty(); });
  }
  /// Whether any attribute of the child has a value.
  bool has(std::string_view element) const {
    return std::ranges::any_of(values_, [&](const auto& v) {
      return v.first.starts_with(element) && v.first[element.size()] == '.' &&
             !xml::trimmed(v.second).empty();
    });
  }

  std::string text(const std::string& path) {
    const auto found = values_.find(path);
    const std::optional<std::string> value = unescaped(found == values_.end() ? "" : found->second);
    if (found == values_.end()) fail(path + " is missing");
    if (!value) fail(path + " has an unknown entity");
    return text::device_text(value.value_or(""));
  }

  template <typename Integer>
  Integer integer(const std::string& path) {
    const auto value = read(path, "an integer", [](std::string_view text) {
      const auto whole = xml::to_whole_number(text);
      return whole && std::in_range<Integer>(*whole) ? whole : std::nullopt;
    });
    return static_cast<Integer>(value);
  }

  std::optional<int> integer_if_there(const std::string& path) {
    return raw(path).empty() ? std::nullopt : std::optional{integer<int>(path)};
  }

  bool flag(const std::string& path) {
    return read(path, "0 or 1, or FALSE or TRUE", [](std::string_view text) -> std::optional<bool> {
      if (equal_ignoring_case(text, "TRUE")) return true;
      if (equal_ignoring_case(text, "FALSE")) return false;
      const auto number = xml::to_whole_number(text);
      return number == 0 || number == 1 ? std::optional{number == 1} : std::nullopt;
    });
  }

  /// @param allowed  every enumerator
  template <typename Enum>
  Enum enumerator(const std::string& path, std::initializer_list<Enum> allowed) {
    const int value = integer<int>(path);
    for (const Enum candidate : allowed) {
      if (static_cast<int>(candidate) == value) return candidate;
    }
    fail(path + " is " + std::to_string(value) + ", which has no meaning");
    return *allowed.begin();
  }

  std::array<double, 6> six(const std::string& element, const Names& names) {
    std::array<double, 6> values{};
    for (std::size_t i = 0; i < names.size(); ++i) {
      values[i] = read(element + "." + std::string{names[i]}, "a finite number", xml::to_number<double>);
    }
    return values;
  }

  Axes axes_rad() { return scaled(six("Ax", kAxisNames), kRadPerDeg); }

 private:
  /// What is written there, or nothing.
  std::string_view raw(const std::string& path) const {
    const auto found = values_.find(path);
    return found == values_.end() ? std::string_view{} : xml::trimmed(found->second);
  }

  /// @param parse  gives an optional
  template <typename Parse>
  typename std::invoke_result_t<Parse, std::string_view>::value_type read(const std::string& path,
                                                                          const char* expected, Parse parse) {
    const std::string_view text = raw(path);
    const auto value = parse(text);
    if (text.empty()) {
      fail(path + " is missing");
    } else if (!value) {
      fail(path + " is \"" + text::device_text(text) + "\", expected " + expected);
    }
    return value ? *value : std::remove_cvref_t<decltype(*value)>{};
  }

  void fail(const std::string& sentence) {
    if (!error_) error_ = text::device_text(name_) + ": " + text::device_text(sentence);
  }

  std::string_view name_;
  std::set<std::string_view> elements_;
  std::map<std::string, std::string_view> values_;
  std::optional<std::string> error_;
};

/// One document: the messages in it and what its root is called.
struct Document {
  std::string_view root;
  std::vector<Fields> messages;  ///< the root itself, or what is below kManyInOne
};

constexpr std::string_view kManyInOne = "Robot";

std::expected<Document, std::string> parse(std::string_view text) {
  using Event = xml::Scanner::Event;
  Document document;
  xml::Scanner scanner{text};
  std::size_t message_depth = 1;
  for (;;) {
    switch (scanner.next()) {
      case Event::Open:
        if (scanner.depth() == 1) {
          document.root = scanner.name();
          message_depth = document.root == kManyInOne ? 2 : 1;
        }
        if (scanner.depth() == message_depth) document.messages.emplace_back(scanner.name());
        if (scanner.depth() == message_depth || scanner.depth() == message_depth + 1)
          document.messages.back().take(scanner, scanner.depth() > message_depth);
        break;
      case Event::Text:
      case Event::Close:
        break;
      case Event::End:
        return document;
      case Event::Malformed:
        return std::unexpected((document.root.empty() ? "" : text::device_text(document.root) + ": ") +
                               "not a well-formed document (at byte " + std::to_string(scanner.offset()) +
                               ")");
    }
  }
}

Command read_command(Fields& fields) {
  using enum CommandType;
  Command command;
  command.id = fields.integer<std::int32_t>("Id");
  command.type = fields.enumerator("Type", {Ptp, StartRsi, NoOp});
  command.velocity_percent = fields.integer<int>("Vel");
  command.acceleration_percent = fields.integer<int>("Acc");
  command.settle_ms = fields.integer<int>("Settle");
  command.axes_rad = fields.axes_rad();
  return command;
}

Control read_control(Fields& fields) {
  using enum ControlOp;
  Control control;
  control.id = fields.integer<std::int32_t>("Id");
  control.op = fields.enumerator("Op", {SetOverride, Stop, ReleaseStop, Drives, AskState});
  control.value = fields.integer<int>("Val");
  return control;
}

Ack read_ack(Fields& fields) {
  using enum AckState;
  Ack ack;
  ack.id = fields.integer<std::int32_t>("Id");
  ack.state = fields.enumerator("State", {Accepted, Moving, InPosition, Rejected, Aborted});
  ack.error = fields.integer<int>("Err");
  if (fields.has("Ax")) ack.axes_rad = fields.axes_rad();
  return ack;
}

Hello read_hello(Fields& fields) {
  Hello hello;
  hello.version = fields.integer<int>("Ver");
  hello.model = fields.text("Model");
  hello.serial = fields.text("Serial");
  hello.tool = fields.integer_if_there("Tool");
  hello.base = fields.integer_if_there("Base");
  hello.kss_version = fields.text("KssVer");
  return hello;
}

State read_state(Fields& fields) {
  State state;
  state.sequence = fields.integer<std::int32_t>("Seq");
  state.id = fields.integer<std::int32_t>("Id");
  state.mode = fields.enumerator(
      "ModeOp", {OperatingMode::T1, OperatingMode::T2, OperatingMode::Aut, OperatingMode::Ext});
  state.override_percent = fields.integer<int>("OvPro");
  state.program =
      fields.enumerator("ProState", {ProgramState::Free, ProgramState::Reset, ProgramState::Active,
                                     ProgramState::Stopped, ProgramState::Ended});
  state.drives_ready = fields.flag("PeriRdy");
  state.no_emergency_stop = fields.flag("AlarmStop");
  state.gate_closed = fields.flag("UserSaf");
  state.stop_message = fields.flag("StopMess");
  state.moving = fields.flag("ProMove");
  state.in_position = fields.flag("InPos");
  state.axes_rad = fields.axes_rad();
  state.pose = fields.six("Pos", kPoseNames);
  state.base = fields.integer_if_there("Base.No");
  state.tool = fields.integer_if_there("Tool.No");
  return state;
}

std::string unknown(std::string_view root) {
  return "the document <" + text::device_text(root) + "> is not known here";
}

std::optional<ToController> read_to_controller(Fields& fields) {
  if (fields.name() == "Cmd") return read_command(fields);
  if (fields.name() == "Ctl") return read_control(fields);
  return std::nullopt;
}

std::optional<FromController> read_from_controller(Fields& fields) {
  if (fields.name() == "Ack") return read_ack(fields);
  if (fields.name() == "State") return read_state(fields);
  if (fields.name() == "Hello") return read_hello(fields);
  return std::nullopt;
}

}  // namespace

std::string encode(const ToController& message) {
  return std::visit([](const auto& m) { return to_xml(m); }, message);
}

std::string encode(const FromController& message) {
  return std::visit([](const auto& m) { return to_xml(m); }, message);
}

std::expected<ToController, std::string> decode_to_controller(std::string_view text) {
  auto document = parse(text);
  if (!document) return std::unexpected(document.error());
  if (document->messages.empty()) return std::unexpected(unknown(document->root));
  Fields& fields = document->messages.front();
  const std::optional<ToController> message = read_to_controller(fields);
  if (!message) return std::unexpected(unknown(document->root));
  if (fields.error()) return std::unexpected(*fields.error());
  return *message;
}

std::expected<std::vector<FromController>, std::string> decode_from_controller(std::string_view text) {
  auto document = parse(text);
  if (!document) return std::unexpected(document.error());
  std::vector<FromController> messages;
  for (Fields& fields : document->messages) {
    const bool says_nothing = fields.is_blank();
    std::optional<FromController> message = read_from_controller(fields);
    if (!message && document->root != kManyInOne) return std::unexpected(unknown(document->root));
    if (!message || says_nothing) continue;
    if (fields.error()) return std::unexpected(*fields.error());
    messages.push_back(*std::move(message));
  }
  return messages;
}

}  // namespace truepose::eki
