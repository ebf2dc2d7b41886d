// Frames of the controller. A second XML reader must see every value of an accepted one as we do.
#include <array>
#include <cstdlib>
#include <optional>
#include <pugixml.hpp>
#include <string>

#include "core/math/angles.hpp"
#include "proto/rsi/frame_codec.hpp"
#include "proto/rsi/frame_layout.hpp"
#include "tests/fuzz/target.hpp"

namespace truepose::fuzz {
namespace {

using rsi::Axes;

constexpr std::array kAxes{"A1", "A2", "A3", "A4", "A5", "A6"};
constexpr std::array kExternal{"E1", "E2", "E3", "E4", "E5", "E6"};
constexpr std::array kPose{"X", "Y", "Z", "A", "B", "C"};

/// pugixml wants a name to begin with a letter, which KUKA's 01="1" does not.
bool is_name_of_kuka(std::string_view text, std::size_t at) {
  const auto is_one = [](char c) { return (c >= '0' && c <= '9') || c == '-' || c == '.'; };
  return (at < text.size() && is_one(text[at])) || (at > 0 && is_one(text[at - 1]));
}

/// pugixml reads a little of what stands in <?...?>, which we skip.
bool is_other_reader_s(const pugi::xml_parse_result& parsed, std::string_view text) {
  return parsed.status == pugi::status_bad_pi ||
         is_name_of_kuka(text, static_cast<std::size_t>(parsed.offset));
}

void expect_agreement(const pugi::xml_node& root, const char* name,
                      const std::array<const char*, 6>& attributes, const std::optional<Axes>& values,
                      double scale, bool unread) {
  const pugi::xml_node element = root.child(name);
  if (!values) return expect(!element || unread, std::string{name} + " is read, or something is said of it");
  expect(element && !element.next_sibling(name), std::string{name} + " is there, and once");
  for (std::size_t i = 0; i < attributes.size(); ++i) {
    const char* text = element.attribute(attributes[i]).value();
    expect((*values)[i] == std::strtod(text, nullptr) * scale,
           std::string{name} + "." + attributes[i] + " has the value of its text");
  }
}

void expect_agreement(const rsi::RobotFrame& frame, std::string_view datagram) {
  const std::string_view text = datagram.substr(0, datagram.find('\0'));
  pugi::xml_document document;
  const pugi::xml_parse_result parsed =
      document.load_buffer(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!parsed && is_other_reader_s(parsed, text)) return;
  expect(parsed, std::string{"an accepted frame is well formed, not: "} + parsed.description());
  const pugi::xml_node root = document.child("Rob");
  const bool unread = frame.unread.has_value();
  expect(frame.ipoc == std::strtoull(root.child_value("IPOC"), nullptr, 10),
         "IPOC has the value of its text");
  expect_agreement(root, "AIPos", kAxes, frame.aipos_rad, kRadPerDeg, unread);
  expect_agreement(root, "ASPos", kAxes, frame.aspos_rad, kRadPerDeg, unread);
  expect_agreement(root, "EIPos", kExternal, frame.eipos, 1, unread);
  expect_agreement(root, "ESPos", kExternal, frame.espos, 1, unread);
  const auto as_axes = [](const std::optional<rsi::CartesianPose>& p) {
    return p ? std::optional<Axes>{{p->x_mm, p->y_mm, p->z_mm, p->a_deg, p->b_deg, p->c_deg}} : std::nullopt;
  };
  expect_agreement(root, "RIst", kPose, as_axes(frame.rist), 1, unread);
  expect_agreement(root, "RSol", kPose, as_axes(frame.rsol), 1, unread);
  if (frame.delay) {
    const char* delay = root.child("Delay").attribute("D").value();
    expect(static_cast<double>(*frame.delay) == std::strtod(delay, nullptr),
           "Delay has the value of its text");
  }
}

void expect_round_trip(const rsi::RobotFrame& frame) {
  std::array<char, rsi::kMaxFrameBytes> buffer;
  const auto text = rsi::encode_robot_frame(frame, buffer, 15);
  if (!text) return;  // numbers of hundreds of digits
  const auto again = rsi::decode_robot_frame(*text);
  expect(again && again->ipoc == frame.ipoc && again->delay == frame.delay, "what is written is read again");
}

/// After a good frame, after this one, and after this one and a good one.
void expect_one_decoding(std::string_view input) {
  constexpr std::string_view kGood =
      R"(<Rob Type="KUKA"><RIst X="1765.0" Y="-0.125" Z="1910" A="-180.0" B="89.5" C="0.0"/>)"
      R"(<ASPos A1="0.0" A2="-90.0" A3="90.0" A4="0.5" A5="12.345678" A6="-350.0"/><Tech C1="0.5"/>)"
      R"(<Delay D="3"/><Tp Ask="1" Pro="3" Mode="4"/><IPOC>4208163</IPOC></Rob>)";
  const auto expected = rsi::decode_robot_frame(input);
  rsi::RobotFrameDecoder decoder;
  for (const std::string_view before : {kGood, input, kGood}) {
    decoder.decode(before);
    expect(decoder.decode(input) == expected, "a frame is decoded alike whatever came before it");
  }
}

}  // namespace

void rsi_frame(std::string_view input) {
  expect_one_decoding(input);
  const auto frame = rsi::decode_robot_frame(input);
  if (!frame) {
    expect(!rsi::describe(frame.error()).empty() && frame.error().offset <= input.size(),
           "a fault says where");
    return;
  }
  expect_agreement(*frame, input);
  expect_round_trip(*frame);
}

}  // namespace truepose::fuzz
