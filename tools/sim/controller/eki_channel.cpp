#include "tools/sim/controller/eki_channel.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <pugixml.hpp>
#include <sstream>

namespace truepose::sim {
namespace {

using krl::Value;

/// The attributes of a frame, in the order of its components.
constexpr std::string_view kFrameAttributes = "XYZABC";

std::string frame_tag(std::string_view element, char attribute) {
  return std::string{element} + "/@" + attribute;
}

template <typename Number>
std::optional<Value> number_in(std::string_view text) {
  Number number{};
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (fault != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::optional<Value> value_in(const std::string& text, EkiFile::Type type) {
  switch (type) {
    case EkiFile::Type::Int:
      return number_in<std::int32_t>(text);
    case EkiFile::Type::Real:
      return number_in<double>(text);
    case EkiFile::Type::Bool:
      if (text == "1" || text == "0") return text == "1";
      return std::nullopt;
    case EkiFile::Type::String:
      return text;
    case EkiFile::Type::Frame:
      break;  // lies in several attributes
  }
  return std::nullopt;
}

struct WrittenValue {
  std::string operator()(std::int32_t number) const { return std::to_string(number); }
  std::string operator()(double number) const {
    std::array<char, 64> digits;
    const auto end =
        std::to_chars(digits.data(), digits.data() + digits.size(), number, std::chars_format::fixed, 6);
    return {digits.data(), end.ptr};
  }
  std::string operator()(bool flag) const { return flag ? "1" : "0"; }
  std::string operator()(const std::string& text) const { return text; }
  std::string operator()(const auto&) const { return {}; }
};

/// "Ack/Ax/@A1" of a document: its text, where it has it.
std::optional<std::string> text_at(const pugi::xml_document& document, std::string_view tag) {
  pugi::xml_node node = document;
  for (std::size_t slash; (slash = tag.find('/')) != std::string_view::npos; tag.remove_prefix(slash + 1))
    node = node.child(std::string{tag.substr(0, slash)}.c_str());
  if (tag.starts_with('@')) {
    const pugi::xml_attribute attribute = node.attribute(std::string{tag.substr(1)}.c_str());
    return attribute ? std::optional<std::string>{attribute.value()} : std::nullopt;
  }
  node = node.child(std::string{tag}.c_str());
  return node ? std::optional<std::string>{node.child_value()} : std::nullopt;
}

/// X to C of a frame's element. Errors: the attribute that it does not have, or that is no number.
std::expected<Value, std::string> frame_at(const pugi::xml_document& document, std::string_view element) {
  krl::Parts frame;
  for (const char attribute : kFrameAttributes) {
    const std::string tag = frame_tag(element, attribute);
    const auto text = text_at(document, tag);
    if (!text) return std::unexpected(tag + " is missing");
    const auto number = number_in<double>(*text);
    if (!number) return std::unexpected(tag + " is \"" + *text + "\", which is no number");
    frame.push_back(*number);
  }
  return frame;
}

/// Of a received element. Errors: why it has no value of its type.
std::expected<Value, std::string> value_at(const pugi::xml_document& document, std::string_view tag,
                                           const std::string& text, EkiFile::Type type) {
  if (type == EkiFile::Type::Frame) return frame_at(document, tag);
  auto value = value_in(text, type);
  if (!value) return std::unexpected(std::string{tag} + " is \"" + text + "\", which is not of its type");
  return *std::move(value);
}

/// Writes a value where its tag says.
void put(pugi::xml_document& document, std::string_view tag, const std::string& text) {
  pugi::xml_node node = document;
  const auto child = [&node](std::string_view name) {
    const std::string own{name};
    const pugi::xml_node there = node.child(own.c_str());
    return there ? there : node.append_child(own.c_str());
  };
  for (std::size_t slash; (slash = tag.find('/')) != std::string_view::npos; tag.remove_prefix(slash + 1))
    node = child(tag.substr(0, slash));
  if (tag.starts_with('@')) {
    node.append_attribute(std::string{tag.substr(1)}.c_str()) = text.c_str();
  } else {
    child(tag).text().set(text.c_str());
  }
}

void put_value(pugi::xml_document& document, const std::string& tag, const Value& value) {
  const auto* const frame = std::get_if<krl::Parts>(&value);
  if (frame == nullptr) return put(document, tag, std::visit(WrittenValue{}, value));
  for (std::size_t i = 0; i < frame->size(); ++i)
    put(document, frame_tag(tag, kFrameAttributes[i]), std::visit(WrittenValue{}, (*frame)[i]));
}

bool lies_in(std::string_view tag, std::string_view element) {
  return tag.starts_with(element) && (tag.size() == element.size() || tag[element.size()] == '/');
}

}  // namespace

void EkiChannel::clear() {
  received_.clear();
  to_send_.clear();
  is_initialised_ = is_open_ = is_connected_ = was_lost_ = false;
}

bool EkiChannel::open() {
  if (!is_initialised_ || was_lost_) return false;
  is_open_ = true;
  return true;
}

std::size_t EkiChannel::waiting(std::string_view tag) const {
  const auto found = received_.find(tag);
  return found == received_.end() ? 0 : found->second.size();
}

std::expected<Value, std::string> EkiChannel::take(std::string_view tag, EkiFile::Type type) {
  const auto element = std::ranges::find(file_.receive, tag, &EkiFile::Received::tag);
  if (element == file_.receive.end() || element->type != type)
    return std::unexpected("RECEIVE has no " + std::string{tag} + " of this type");
  const auto found = received_.find(tag);
  if (found == received_.end() || found->second.empty())
    return std::unexpected("no value of " + std::string{tag} + " is left");
  Value value = std::move(found->second.front());
  found->second.pop_front();
  return value;
}

void EkiChannel::clear_buffer(std::string_view element) {
  std::erase_if(received_, [element](const auto& one) { return lies_in(one.first, element); });
}

bool EkiChannel::sends(std::string_view tag) const {
  return std::ranges::find(file_.send, tag) != file_.send.end();
}

std::expected<void, std::string> EkiChannel::set(std::string_view tag, Value value) {
  if (const auto* const frame = std::get_if<krl::Parts>(&value)) {
    if (!std::ranges::all_of(*frame, krl::is_set))
      return std::unexpected("a component of the frame for " + std::string{tag} + " has no value");
    if (!sends(tag)) return set_frame(tag, *frame);
  }
  if (!sends(tag)) return std::unexpected("SEND has no " + std::string{tag});
  to_send_.insert_or_assign(std::string{tag}, std::move(value));
  return {};
}

/// Where SEND lists the attributes one by one.
std::expected<void, std::string> EkiChannel::set_frame(std::string_view tag, const krl::Parts& frame) {
  for (std::size_t i = 0; i < frame.size(); ++i) {
    if (const auto set_one = set(frame_tag(tag, kFrameAttributes[i]), frame[i]); !set_one) return set_one;
  }
  return {};
}

std::expected<std::string, std::string> EkiChannel::document(std::string_view element) const {
  pugi::xml_document document;
  bool has_any = false;
  for (const std::string& tag : file_.send) {
    if (!lies_in(tag, element)) continue;
    has_any = true;
    if (const auto value = to_send_.find(tag); value != to_send_.end())
      put_value(document, tag, value->second);
  }
  if (!has_any) return std::unexpected("SEND has nothing in " + std::string{element});
  std::ostringstream text;
  document.save(text, "",
                pugi::format_raw | pugi::format_no_declaration | pugi::format_no_empty_element_tags);
  return text.str();
}

void EkiChannel::disconnect() {
  was_lost_ = std::exchange(is_connected_, false);
  is_open_ = false;
}

std::expected<std::vector<int>, std::string> EkiChannel::receive(std::string_view bytes) {
  pugi::xml_document document;
  if (const auto parsed = document.load_buffer(bytes.data(), bytes.size()); !parsed)
    return std::unexpected("a document is not XML: " + std::string{parsed.description()});
  std::vector<std::pair<std::string_view, Value>> values;
  std::vector<int> flags;
  for (const EkiFile::Received& element : file_.receive) {
    const auto text = text_at(document, element.tag);
    if (!text) continue;
    if (element.flag) flags.push_back(*element.flag);
    if (!element.type) continue;
    auto value = value_at(document, element.tag, *text, *element.type);
    if (!value) return std::unexpected(value.error());
    if (waiting(element.tag) == file_.buffered)
      return std::unexpected("the buffer of " + element.tag + " is full, a document is lost");
    values.emplace_back(element.tag, *std::move(value));
  }
  for (auto& [tag, value] : values) received_[std::string{tag}].push_back(std::move(value));
  return flags;
}

}  // namespace truepose::sim
