#include "proto/eki/messages.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <concepts>
#include <map>
#include <set>
#include <type_traits>
#include <utility>

#include "proto/record/forms.hpp"
#include "proto/text/device_text.hpp"
#include "proto/text/kuka_names.hpp"
#include "proto/xml/escape.hpp"
#include "proto/xml/scanner.hpp"

namespace truepose::eki {
namespace {

using record::Degrees;

/// A message or a constant one, for a layout that writes and reads.
template <class T, class Message>
concept Is = std::same_as<std::remove_const_t<T>, Message>;

/// The one root of what the controller sends on a channel, as KUKA's own examples have it.
constexpr std::string_view kControllerRoot = "Robot";

// ---- Layouts: the attributes of each message in the order in which they are written, those of a child
// behind its name: "Ax.A1". Enumerations are numbers, of which those listed have a meaning.

template <class Message>
constexpr std::string_view kElement{};
template <>
constexpr std::string_view kElement<Command> = "Cmd";
template <>
constexpr std::string_view kElement<Control> = "Ctl";
template <>
constexpr std::string_view kElement<Ack> = "Ack";
template <>
constexpr std::string_view kElement<Hello> = "Hello";
template <>
constexpr std::string_view kElement<State> = "State";

void layout(auto& io, Is<Command> auto& x) {
  using enum CommandType;
  io("Id", x.id);
  io("Type", x.type, {Ptp, StartRsi, NoOp});
  io("Vel", x.velocity_percent);
  io("Acc", x.acceleration_percent);
  io("Settle", x.settle_ms);
  io.six("Ax", kAxisNames, x.axes_rad, Degrees{});
}
void layout(auto& io, Is<Control> auto& x) {
  using enum ControlOp;
  io("Id", x.id);
  io("Op", x.op, {SetOverride, Stop, ReleaseStop, Drives, AskState});
  io("Val", x.value);
}
void layout(auto& io, Is<Ack> auto& x) {
  using enum AckState;
  io("Id", x.id);
  io("State", x.state, {Accepted, Moving, InPosition, Rejected, Aborted});
  io("Err", x.error);
  io.six("Ax", kAxisNames, x.axes_rad, Degrees{});
}
void layout(auto& io, Is<Hello> auto& x) {
  io("Ver", x.version);
  io("Model", x.model);
  io("Serial", x.serial);
  io("Tool", x.tool);
  io("Base", x.base);
  io("KssVer", x.kss_version);
}
void layout(auto& io, Is<State> auto& x) {
  using enum OperatingMode;
  using enum ProgramState;
  io("Seq", x.sequence);
  io("Id", x.id);
  io("ModeOp", x.mode, {T1, T2, Aut, Ext});
  io("OvPro", x.override_percent);
  io("ProState", x.program, {Free, Reset, Active, Stopped, Ended});
  io("PeriRdy", x.drives_ready);
  io("AlarmStop", x.no_emergency_stop);
  io("UserSaf", x.gate_closed);
  io("StopMess", x.stop_message);
  io("ProMove", x.moving);
  io("InPos", x.in_position);
  io("Serial", x.serial);
  io.six("Ax", kAxisNames, x.axes_rad, Degrees{});
  io.six("Pos", kPoseNames, x.pose);
  io("Base.No", x.base);
  io("Tool.No", x.tool);
  io.six("ToolFrame", kPoseNames, x.tool_frame);
  io.six("BaseFrame", kPoseNames, x.base_frame);
  io("Load.M", x.load_kg);
}

// ---- Writing

/// One element with its children; written as an open and close pair.
class Element {
 public:
  explicit Element(std::string_view name) : name_{name} { text_.append("<").append(name); }

  void operator()(std::string_view path, std::string_view value) {
    const std::size_t dot = path.find('.');
    if (dot != std::string_view::npos) return child(path.substr(0, dot))(path.substr(dot + 1), value);
    text_.append(" ").append(path).append("=\"").append(xml::escaped(value)).append("\"");
  }
  void operator()(std::string_view path, std::integral auto value) { (*this)(path, std::to_string(+value)); }
  void operator()(std::string_view path, const std::optional<int>& value) {
    if (value) (*this)(path, *value);
  }
  void operator()(std::string_view path, const std::optional<double>& value) {
    if (value) (*this)(path, number(*value));
  }
  template <class Enum>
  void operator()(std::string_view path, Enum value, std::initializer_list<Enum>) {
    (*this)(path, static_cast<int>(value));
  }
  template <class... Form>
  void six(std::string_view element, const SixNames& names, const std::array<double, 6>& values,
           const Form&... form) {
    for (std::size_t i = 0; i < names.size(); ++i)
      child(element)(names[i], number(form_of(values[i], form...)));
  }
  template <class... Form>
  void six(std::string_view element, const SixNames& names, const std::optional<Axes>& values,
           const Form&... form) {
    if (values) six(element, names, *values, form...);
  }
  std::string str() const {
    std::string children;
    for (const Element& child : children_) children += child.str();
    return text_ + ">" + children + "</" + std::string{name_} + ">";
  }

 private:
  Element& child(std::string_view name) {
    if (children_.empty() || children_.back().name_ != name) children_.emplace_back(name);
    return children_.back();
  }
  static double form_of(double value) { return value; }
  static double form_of(double value, Degrees degrees) { return degrees.form_of(value); }
  static std::string number(double value) {
    constexpr int kDecimals = 6;   // KRL's REAL has seven digits
    std::array<char, 400> digits;  // room for the longest double without exponent
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value,
                                   std::chars_format::fixed, kDecimals);
    return {digits.data(), end.ptr};
  }

  std::string_view name_;
  std::string text_;
  std::vector<Element> children_;
};

template <class Message>
std::string written(const Message& message) {
  Element element{kElement<Message>};
  layout(element, message);
  return element.str();
}

// ---- Reading

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
  void operator()(const std::string& path, std::string& x) {
    const auto found = values_.find(path);
    const std::optional<std::string> value = unescaped(found == values_.end() ? "" : found->second);
    if (found == values_.end()) fail(path + " is missing");
    if (!value) fail(path + " has an unknown entity");
    x = text::device_text(value.value_or(""));
  }
  template <std::integral Integer>
  void operator()(const std::string& path, Integer& x) {
    x = static_cast<Integer>(read(path, "an integer", [](std::string_view text) {
      const auto whole = xml::to_whole_number(text);
      return whole && std::in_range<Integer>(*whole) ? whole : std::nullopt;
    }));
  }
  void operator()(const std::string& path, bool& x) {
    x = read(path, "0 or 1, or FALSE or TRUE", [](std::string_view text) -> std::optional<bool> {
      if (equal_ignoring_case(text, "TRUE")) return true;
      if (equal_ignoring_case(text, "FALSE")) return false;
      const auto number = xml::to_whole_number(text);
      return number == 0 || number == 1 ? std::optional{number == 1} : std::nullopt;
    });
  }
  void operator()(const std::string& path, std::optional<int>& x) {
    x.reset();
    if (!raw(path).empty()) (*this)(path, x.emplace());
  }
  void operator()(const std::string& path, std::optional<double>& x) {
    x.reset();
    if (!raw(path).empty()) x = read(path, "a finite number", xml::to_number<double>);
  }
  template <class Enum>
  void operator()(const std::string& path, Enum& x, std::initializer_list<Enum> allowed) {
    int number = 0;
    (*this)(path, number);
    x = static_cast<Enum>(number);
    if (std::ranges::count(allowed, x) == 0)
      fail(path + " is " + std::to_string(number) + ", which has no meaning");
  }
  template <class... Form>
  void six(const std::string& element, const SixNames& names, std::array<double, 6>& values,
           const Form&... form) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      values[i] = read(element + "." + std::string{names[i]}, "a finite number", xml::to_number<double>);
      ((values[i] = form.value_of(values[i])), ...);
    }
  }
  /// There are such values where any attribute of the child has one.
  template <class... Form>
  void six(const std::string& element, const SixNames& names, std::optional<Axes>& values,
           const Form&... form) {
    const bool there = std::ranges::any_of(values_, [&](const auto& v) {
      return v.first.starts_with(element + ".") && !xml::trimmed(v.second).empty();
    });
    if (there) six(element, names, values.emplace(), form...);
  }

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
  std::vector<Fields> messages;  ///< the root itself, or what is below kControllerRoot
};

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
          message_depth = document.root == kControllerRoot ? 2 : 1;
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

std::string unknown(std::string_view root) {
  return "the document <" + text::device_text(root) + "> is not known here";
}

template <class Message>
Message read(Fields& fields) {
  Message message;
  layout(fields, message);
  return message;
}

/// The one of some messages that has the name of the element.
template <class... Messages>
void read_one(Fields& fields, std::optional<std::variant<Messages...>>& message) {
  ((fields.name() == kElement<Messages> ? void(message = read<Messages>(fields)) : void()), ...);
}

}  // namespace

std::string_view name(OperatingMode mode) {
  constexpr std::array<std::string_view, 4> kNames{"T1", "T2", "AUT", "EXT"};
  return kNames[static_cast<std::size_t>(mode) - 1];
}

std::string_view name(ProgramState state) {
  constexpr std::array<std::string_view, 5> kNames{"free", "reset", "active", "stopped", "ended"};
  return kNames[static_cast<std::size_t>(state) - 1];
}

std::string encode(const ToController& message) {
  return std::visit([](const auto& m) { return written(m); }, message);
}

std::string encode(const FromController& message) {
  const std::string root{kControllerRoot};
  return "<" + root + ">" + std::visit([](const auto& m) { return written(m); }, message) + "</" + root + ">";
}

std::expected<ToController, std::string> decode_to_controller(std::string_view text) {
  auto document = parse(text);
  if (!document) return std::unexpected(document.error());
  if (document->messages.empty()) return std::unexpected(unknown(document->root));
  Fields& fields = document->messages.front();
  std::optional<ToController> message;
  read_one(fields, message);
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
    std::optional<FromController> message;
    read_one(fields, message);
    if (!message && document->root != kControllerRoot) return std::unexpected(unknown(document->root));
    if (!message || says_nothing) continue;
    if (fields.error()) return std::unexpected(*fields.error());
    messages.push_back(*std::move(message));
  }
  return messages;
}

}  // namespace truepose::eki
