#include <benchmark/benchmark.h>
#include <tinyxml.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <pugixml.hpp>
#include <string>
#include <vector>

#include "core/math/angles.hpp"
#include "core/math/random.hpp"
#include "proto/rsi/frame_layout.hpp"

namespace truepose::bench {
namespace {

using rsi::Axes;
using rsi::RobotFrame;

constexpr std::array kPoseNames{"X", "Y", "Z", "A", "B", "C"};
constexpr std::array kAxisNames{"A1", "A2", "A3", "A4", "A5", "A6"};

/// What KUKA's RSI sends by default, 414 bytes, with other numbers every time.
std::vector<std::string> datagrams() {
  constexpr int kDatagrams = 256;
  Random random{7};
  const auto six = [&](const char* element, const auto& names, double least, double greatest) {
    std::string text = std::string{"<"} + element;
    for (const char* name : names) {
      char number[64];
      std::snprintf(number, sizeof number, " %s=\"%.4f\"", name, random.uniform(least, greatest));
      text += number;
    }
    return text + "/>";
  };
  std::vector<std::string> all;
  while (all.size() < kDatagrams) {
    const std::string text = "<Rob Type=\"KUKA\">" + six("RIst", kPoseNames, -2000, 2000) +
                             six("RSol", kPoseNames, -2000, 2000) + six("AIPos", kAxisNames, -180, 180) +
                             six("ASPos", kAxisNames, -180, 180) + "<Delay D=\"0\"/><IPOC>" +
                             std::to_string(4208163 + 4 * all.size()) + "</IPOC></Rob>";
    if (text.size() == 414) all.push_back(text);
  }
  return all;
}

rsi::EthernetConfig configuration() {
  rsi::EthernetConfig config;
  config.sentype = "TruePose";
  config.axis_correction = "AK";
  config.stop = "Stop";
  for (const char* axis : kAxisNames)
    config.receive.push_back({std::string{"AK."} + axis, rsi::ElementType::Double, 1, true});
  config.receive.push_back({"Stop", rsi::ElementType::Bool, 7, true});
  return config;
}

/// What is answered: a small part of the commanded axes.
rsi::SensorFrame answer_to(const RobotFrame& frame) {
  rsi::SensorFrame answer{.ipoc = frame.ipoc, .axis_correction_rad = Axes{}, .stop = false};
  for (std::size_t i = 0; i < 6; ++i) (*answer.axis_correction_rad)[i] = 0.001 * (*frame.aspos_rad)[i];
  return answer;
}

// ---- The peers, each as its own documentation has it ----

Axes axes_of(const auto& element, const auto& names, double scale, auto number_of) {
  Axes axes{};
  for (std::size_t i = 0; i < axes.size(); ++i) axes[i] = number_of(element, names[i]) * scale;
  return axes;
}

RobotFrame frame_of(const auto& root, auto child, auto number_of, auto text_of) {
  const auto pose = [&](const char* name) {
    const Axes v = axes_of(child(root, name), kPoseNames, 1, number_of);
    return rsi::CartesianPose{v[0], v[1], v[2], v[3], v[4], v[5]};
  };
  RobotFrame frame;
  frame.ipoc = std::strtoull(text_of(child(root, "IPOC")), nullptr, 10);
  frame.rist = pose("RIst");
  frame.rsol = pose("RSol");
  frame.aipos_rad = axes_of(child(root, "AIPos"), kAxisNames, kRadPerDeg, number_of);
  frame.aspos_rad = axes_of(child(root, "ASPos"), kAxisNames, kRadPerDeg, number_of);
  frame.delay = static_cast<std::int64_t>(number_of(child(root, "Delay"), "D"));
  return frame;
}

RobotFrame read_with_tinyxml(const std::string& datagram) {
  TiXmlDocument document;
  document.Parse(datagram.c_str());
  const auto child = [](const TiXmlElement* element, const char* name) {
    return element->FirstChildElement(name);
  };
  const auto number = [](const TiXmlElement* element, const char* name) {
    return std::strtod(element->Attribute(name), nullptr);
  };
  const auto text = [](const TiXmlElement* element) { return element->GetText(); };
  return frame_of(document.RootElement(), child, number, text);
}

std::string write_with_tinyxml(const rsi::SensorFrame& answer) {
  TiXmlDocument document;
  const auto text_of = [](const char* name, const std::string& text) {
    auto* const element = new TiXmlElement(name);
    element->LinkEndChild(new TiXmlText(text.c_str()));
    return element;
  };
  auto* const root = new TiXmlElement("Sen");
  root->SetAttribute("Type", "TruePose");
  auto* const correction = new TiXmlElement("AK");
  for (std::size_t i = 0; i < 6; ++i) {
    char number[32];
    std::snprintf(number, sizeof number, "%.6f", (*answer.axis_correction_rad)[i] * kDegPerRad);
    correction->SetAttribute(kAxisNames[i], number);
  }
  root->LinkEndChild(correction);
  root->LinkEndChild(text_of("Stop", *answer.stop ? "1" : "0"));
  root->LinkEndChild(text_of("IPOC", std::to_string(answer.ipoc)));
  document.LinkEndChild(root);
  TiXmlPrinter printer;
  printer.SetStreamPrinting();
  document.Accept(&printer);
  return printer.CStr();
}

RobotFrame read_with_pugixml(const std::string& datagram) {
  pugi::xml_document document;
  document.load_buffer(datagram.data(), datagram.size());
  const auto child = [](const pugi::xml_node& node, const char* name) { return node.child(name); };
  const auto number = [](const pugi::xml_node& node, const char* name) {
    return std::strtod(node.attribute(name).value(), nullptr);
  };
  const auto text = [](const pugi::xml_node& node) { return node.child_value(); };
  return frame_of(document.document_element(), child, number, text);
}

/// pugixml writes more slowly than snprintf.
std::string write_with_snprintf(const rsi::SensorFrame& answer) {
  const Axes& axes = *answer.axis_correction_rad;
  char text[512];
  const int size = std::snprintf(
      text, sizeof text,
      R"(<Sen Type="TruePose"><AK A1="%.6f" A2="%.6f" A3="%.6f" A4="%.6f" A5="%.6f" A6="%.6f"/><Stop>%d</Stop><IPOC>%llu</IPOC></Sen>)",
      axes[0] * kDegPerRad, axes[1] * kDegPerRad, axes[2] * kDegPerRad, axes[3] * kDegPerRad,
      axes[4] * kDegPerRad, axes[5] * kDegPerRad, *answer.stop, static_cast<unsigned long long>(answer.ipoc));
  return {text, static_cast<std::size_t>(size)};
}

// ---- The job: a datagram in, its answer out ----

void exchange(benchmark::State& state, auto read, auto write) {
  static const std::vector<std::string> all = datagrams();
  const rsi::SensorFrameCodec codec{configuration()};
  std::array<char, rsi::kMaxFrameBytes> buffer;
  for (const std::string& datagram : all) {
    const RobotFrame frame = rsi::decode_robot_frame(datagram).value();
    if (read(datagram) != frame) state.SkipWithError("other numbers");
    const auto answer = codec.decode(codec.encode(answer_to(frame), buffer).value());
    if (codec.decode(write(answer_to(frame))) != answer) state.SkipWithError("another answer");
  }
  std::size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(write(answer_to(read(all[k]))));
    k = (k + 1) % all.size();
  }
}

/// As the daemon does it.
void exchange_of_the_daemon(benchmark::State& state) {
  rsi::RobotFrameDecoder decoder;
  const rsi::SensorFrameCodec codec{configuration()};
  std::array<char, rsi::kMaxFrameBytes> buffer;
  exchange(
      state, [&](const std::string& datagram) { return decoder.decode(datagram).value(); },
      [&](const rsi::SensorFrame& answer) { return codec.encode(answer, buffer).value(); });
}

BENCHMARK_CAPTURE(exchange, tinyxml, read_with_tinyxml, write_with_tinyxml)->Name("rsi/tinyxml");
BENCHMARK_CAPTURE(exchange, pugixml, read_with_pugixml, write_with_snprintf)->Name("rsi/pugixml");
BENCHMARK(exchange_of_the_daemon)->Name("rsi/truepose");

}  // namespace
}  // namespace truepose::bench
