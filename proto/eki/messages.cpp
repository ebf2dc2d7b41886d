#include "proto/eki/messages.hpp"

#include <algorithm>
#include <charconv>
#include <concepts>
#include <map>
#include <vector>

#include "core/kinematics/angles.hpp"
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
      .set("Tool", hello.tool)
      .set("Base", hello.base)
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
      .add(Element{"Base"}.set("No", state.base))
      .add(Element{"Tool"}.set("No", state.tool))
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

/// The attributes of one document by path: "Id" for the root's, "Ax.A1" for those of its children. A getter
/// that fails leaves the first error behind and returns zero.
class Document {
 public:
  explicit Document(std::string_view text) {
    using Event = xml::Scanner::Event;
    xml::Scanner scanner{text};
    for (;;) {
      switch (scanner.next()) {
        case Event::Open:
          if (scanner.depth() == 1) root_ = scanner.name();
          if (scanner.depth() <= 2) take(scanner);
          break;
        case Event::Text:
        case Event::Close:
          break;
        case Event::End:
          return;
        case Event::Malformed:
          fail("not a well-formed document (at byte " + std::to_string(scanner.offset()) + ")");
          return;
      }
    }
  }

  std::string_view root() const { return root_; }
  const std::optional<std::string>& error() const { return error_; }
  bool has(std::string_view element) const {
    return std::ranges::find(elements_, element) != elements_.end();
  }

  std::string text(const std::string& path) {
    const std::optional<std::string> value = unescaped(raw(path));
    if (!value) fail(path + " has an unknown entity");
    return value.value_or("");
  }

  template <typename Integer>
  Integer integer(const std::string& path) {
    return number<Integer>(path, "an integer");
  }

  bool flag(const std::string& path) {
    const int value = integer<int>(path);
    if (value != 0 && value != 1) fail(path + " is " + std::to_string(value) + ", expected 0 or 1");
    return value == 1;
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
      values[i] = number<double>(element + "." + std::string{names[i]}, "a finite number");
    }
    return values;
  }

  Axes axes_rad() { return scaled(six("Ax", kAxisNames), kRadPerDeg); }

 private:
  void take(const xml::Scanner& scanner) {
    std::string prefix;
    if (scanner.depth() == 2) {
      if (has(scanner.name())) return fail(std::string{scanner.name()} + " comes twice");
      elements_.push_back(scanner.name());
      prefix = std::string{scanner.name()} + ".";
    }
    for (const xml::Attribute& attribute : scanner.attributes()) {
      const std::string path = prefix + std::string{attribute.name};
      if (!values_.emplace(path, attribute.value).second) fail(path + " comes twice");
    }
  }

  std::string_view raw(const std::string& path) {
    const auto found = values_.find(path);
    if (found != values_.end()) return found->second;
    fail(path + " is missing");
    return {};
  }

  template <typename Number>
  Number number(const std::string& path, const char* kind) {
    const std::string_view text = raw(path);
    const std::optional<Number> value = xml::to_number<Number>(text);
    if (!value) fail(path + " is \"" + std::string{text} + "\", expected " + kind);
    return value.value_or(Number{});
  }

  void fail(std::string sentence) {
    if (!error_) error_ = root_.empty() ? std::move(sentence) : std::string{root_} + ": " + sentence;
  }

  std::string_view root_;
  std::vector<std::string_view> elements_;
  std::map<std::string, std::string_view> values_;
  std::optional<std::string> error_;
};

Command read_command(Document& document) {
  using enum CommandType;
  Command command;
  command.id = document.integer<std::int32_t>("Id");
  command.type = document.enumerator("Type", {Ptp, StartRsi, NoOp});
  command.velocity_percent = document.integer<int>("Vel");
  command.acceleration_percent = document.integer<int>("Acc");
  command.settle_ms = document.integer<int>("Settle");
  command.axes_rad = document.axes_rad();
  return command;
}

Control read_control(Document& document) {
  using enum ControlOp;
  Control control;
  control.id = document.integer<std::int32_t>("Id");
  control.op = document.enumerator("Op", {SetOverride, Stop, ReleaseStop, Drives, AskState});
  control.value = document.integer<int>("Val");
  return control;
}

Ack read_ack(Document& document) {
  using enum AckState;
  Ack ack;
  ack.id = document.integer<std::int32_t>("Id");
  ack.state = document.enumerator("State", {Accepted, Moving, InPosition, Rejected, Aborted});
  ack.error = document.integer<int>("Err");
  if (document.has("Ax")) ack.axes_rad = document.axes_rad();
  return ack;
}

Hello read_hello(Document& document) {
  Hello hello;
  hello.version = document.integer<int>("Ver");
  hello.model = document.text("Model");
  hello.serial = document.text("Serial");
  hello.tool = document.integer<int>("Tool");
  hello.base = document.integer<int>("Base");
  hello.kss_version = document.text("KssVer");
  return hello;
}

State read_state(Document& document) {
  State state;
  state.sequence = document.integer<std::int32_t>("Seq");
  state.id = document.integer<std::int32_t>("Id");
  state.mode = document.enumerator(
      "ModeOp", {OperatingMode::T1, OperatingMode::T2, OperatingMode::Aut, OperatingMode::Ext});
  state.override_percent = document.integer<int>("OvPro");
  state.program =
      document.enumerator("ProState", {ProgramState::Free, ProgramState::Reset, ProgramState::Active,
                                       ProgramState::Stopped, ProgramState::Ended});
  state.drives_ready = document.flag("PeriRdy");
  state.no_emergency_stop = document.flag("AlarmStop");
  state.gate_closed = document.flag("UserSaf");
  state.stop_message = document.flag("StopMess");
  state.moving = document.flag("ProMove");
  state.in_position = document.flag("InPos");
  state.axes_rad = document.axes_rad();
  state.pose = document.six("Pos", kPoseNames);
  state.base = document.integer<int>("Base.No");
  state.tool = document.integer<int>("Tool.No");
  return state;
}

template <typename Message>
std::expected<Message, std::string> checked(const Document& document, Message message) {
  if (document.error()) return std::unexpected(*document.error());
  return message;
}

template <typename Message>
std::expected<Message, std::string> unknown(const Document& document) {
  if (document.error()) return std::unexpected(*document.error());
  return std::unexpected("the document <" + std::string{document.root()} + "> is not known here");
}

}  // namespace

std::string encode(const ToController& message) {
  return std::visit([](const auto& m) { return to_xml(m); }, message);
}

std::string encode(const FromController& message) {
  return std::visit([](const auto& m) { return to_xml(m); }, message);
}

std::expected<ToController, std::string> decode_to_controller(std::string_view text) {
  Document document{text};
  if (document.root() == "Cmd") {
    ToController message = read_command(document);
    return checked(document, std::move(message));
  }
  if (document.root() == "Ctl") {
    ToController message = read_control(document);
    return checked(document, std::move(message));
  }
  return unknown<ToController>(document);
}

std::expected<FromController, std::string> decode_from_controller(std::string_view text) {
  Document document{text};
  if (document.root() == "Ack") {
    FromController message = read_ack(document);
    return checked(document, std::move(message));
  }
  if (document.root() == "State") {
    FromController message = read_state(document);
    return checked(document, std::move(message));
  }
  if (document.root() == "Hello") {
    FromController message = read_hello(document);
    return checked(document, std::move(message));
  }
  return unknown<FromController>(document);
}

}  // namespace truepose::eki
