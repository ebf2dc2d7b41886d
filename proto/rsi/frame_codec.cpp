#include "proto/rsi/frame_codec.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/math/angles.hpp"
#include "proto/rsi/frame_numbers.hpp"
#include "proto/rsi/gain_word.hpp"
#include "proto/text/decimal.hpp"
#include "proto/xml/scanner.hpp"

namespace truepose::rsi {
namespace {

using Event = xml::Scanner::Event;
constexpr std::array<std::string_view, 1> kGainNames{"Gain"};
constexpr int kSensorDecimals = 6;

Axes scaled(Axes values, double factor) {
  for (double& value : values) value *= factor;
  return values;
}

std::optional<Axes> scaled(const std::optional<Axes>& values, double factor) {
  return values ? std::optional{scaled(*values, factor)} : std::nullopt;
}

CartesianPose to_pose(const Axes& v) { return {v[0], v[1], v[2], v[3], v[4], v[5]}; }
Axes to_array(const CartesianPose& p) { return {p.x_mm, p.y_mm, p.z_mm, p.a_deg, p.b_deg, p.c_deg}; }

/// One element of a frame: its value, or why it has none, or neither where it is not there.
template <typename T>
struct Found {
  std::optional<T> value;
  std::optional<FrameError> error;

  bool seen() const { return value || error; }
};

/// The elements below the root of one frame, with the first thing that was wrong with the whole.
class FrameReader {
 public:
  explicit FrameReader(std::string_view datagram) : scanner_{datagram} {}

  bool open_root(std::string_view name) {
    if (scanner_.next() != Event::Open) return fail(FrameFault::Malformed);
    return scanner_.name() == name || fail(FrameFault::WrongRoot, name);
  }

  /// Moves to the next element below the root; false at the end of the frame and on an error.
  bool next_element() {
    for (;;) {
      switch (scanner_.next()) {
        case Event::Open:
          if (scanner_.depth() == 2) return true;
          break;
        case Event::Close:
          break;
        case Event::Text:
          if (scanner_.depth() < 2) return fail(FrameFault::Malformed);
          break;
        case Event::End:
          return false;
        case Event::Malformed:
          return fail(FrameFault::Malformed);
      }
    }
  }

  std::string_view name() const { return scanner_.name(); }
  std::span<const xml::Attribute> attributes() const { return scanner_.attributes(); }

  /// Reads the six attributes of the element that is open. False where it comes for the second time; what
  /// else is wrong with it stands in `found`.
  bool read(const SixElement& six, Found<Axes>& found) {
    const std::string_view element = six.name;
    const auto& names = six.attributes.names;
    if (found.seen()) return fail(FrameFault::Duplicate, element);
    if (!scanner_.has_all_attributes()) return note(found, FrameFault::TooMany, element);
    Axes read{};
    unsigned seen = 0;
    std::size_t i = 0;
    for (const xml::Attribute& attribute : attributes()) {
      // Controllers write them in order, which saves the search.
      if (i == names.size() || names[i] != attribute.name) {
        i = static_cast<std::size_t>(std::ranges::find(names, attribute.name) - names.begin());
        if (i == names.size()) continue;
      }
      if (seen & (1u << i)) return fail(FrameFault::Duplicate, element, names[i]);
      seen |= 1u << i;
      const std::optional<double> value = xml::to_number<double>(attribute.value);
      if (!value && !found.error) note(found, FrameFault::BadNumber, element, names[i]);
      read[i] = value.value_or(0);
      ++i;
    }
    for (i = 0; i < names.size(); ++i) {
      if (!found.error && !(seen & (1u << i))) note(found, FrameFault::Missing, element, names[i]);
    }
    if (!found.error) found.value = read;
    return true;
  }

  /// Reads one attribute of the element that is open, a whole number, in the same way.
  bool read(std::string_view element, std::string_view name, Found<std::int64_t>& found) {
    if (found.seen()) return fail(FrameFault::Duplicate, element);
    if (!scanner_.has_all_attributes()) return note(found, FrameFault::TooMany, element);
    for (const xml::Attribute& attribute : attributes()) {
      if (attribute.name != name) continue;
      if (found.seen()) return fail(FrameFault::Duplicate, element, name);
      found.value = xml::to_whole_number(attribute.value);
      if (!found.value) note(found, FrameFault::BadNumber, element, name);
    }
    return found.seen() || note(found, FrameFault::Missing, element, name);
  }

  /// Reads attributes of the element that is open, whole numbers, each of which may be missing.
  bool read(std::string_view element, std::span<const std::string_view> names,
            std::span<std::optional<std::int64_t>> values, std::optional<FrameError>& error) {
    for (const xml::Attribute& attribute : attributes()) {
      const auto place = std::ranges::find(names, attribute.name) - names.begin();
      if (place == std::ssize(names)) continue;
      std::optional<std::int64_t>& value = values[static_cast<std::size_t>(place)];
      if (value) return fail(FrameFault::Duplicate, element, names[static_cast<std::size_t>(place)]);
      value = xml::to_whole_number(attribute.value);
      if (!value)
        error = FrameError{FrameFault::BadNumber, element, names[static_cast<std::size_t>(place)],
                           scanner_.offset()};
    }
    return true;
  }

  /// Makes what is wrong with one element wrong with the whole frame.
  template <typename T>
  bool needs(const Found<T>& found) {
    if (found.error) error_ = found.error;
    return !found.error;
  }

  /// Reads the text of the element that is open and moves behind it.
  bool read(std::string_view element, std::optional<std::uint64_t>& value) {
    if (value) return fail(FrameFault::Duplicate, element);
    const Event event = scanner_.next();
    if (event == Event::Malformed) return fail(FrameFault::Malformed);
    if (event != Event::Text) return fail(FrameFault::Missing, element);
    value = xml::to_number<std::uint64_t>(scanner_.text());
    if (!value) return fail(FrameFault::BadNumber, element);
    const Event end = scanner_.next();
    if (end == Event::Malformed) return fail(FrameFault::Malformed);
    return end == Event::Close || fail(FrameFault::BadNumber, element);
  }

  bool fail(FrameFault fault, std::string_view element = {}, std::string_view attribute = {}) {
    error_ = FrameError{fault, element, attribute, scanner_.offset()};
    return false;
  }

  const std::optional<FrameError>& error() const { return error_; }

 private:
  template <typename T>
  bool note(Found<T>& found, FrameFault fault, std::string_view element, std::string_view attribute = {}) {
    found.error = FrameError{fault, element, attribute, scanner_.offset()};
    return true;
  }

  xml::Scanner scanner_;
  std::optional<FrameError> error_;
};

class FrameWriter {
 public:
  explicit FrameWriter(std::span<char> buffer)
      : begin_{buffer.data()}, at_{begin_}, end_{begin_ + buffer.size()} {}

  FrameWriter& text(std::string_view text) {
    if (static_cast<std::size_t>(end_ - at_) < text.size()) {
      fail({FrameFault::BufferFull, {}, {}, 0});
    } else {
      at_ = std::ranges::copy(text, at_).out;
    }
    return *this;
  }

  template <std::integral Integer>
  FrameWriter& integer(Integer value) {
    return advance(std::to_chars(at_, end_, value));
  }

  void attributes(std::string_view element, const SixAttributes& names, const Axes& values, int decimals) {
    text("<").text(element);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!std::isfinite(values[i])) fail({FrameFault::BadNumber, element, names.names[i], 0});
      text(names.openings[i]);
      advance(text::write_fixed(at_, end_, values[i], decimals));
    }
    text("\"/>");
  }

  /// Of those that there are; no element where there is none.
  void numbers(std::string_view element, std::span<const std::string_view> names,
               std::span<const std::optional<std::int64_t>> values) {
    if (std::ranges::none_of(values, &std::optional<std::int64_t>::has_value)) return;
    text("<").text(element);
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (values[i]) text(" ").text(names[i]).text("=\"").integer(*values[i]).text("\"");
    }
    text("/>");
  }

  std::expected<std::string_view, FrameError> result() const {
    if (error_) return std::unexpected(*error_);
    return std::string_view{begin_, at_};
  }

 private:
  FrameWriter& advance(std::to_chars_result result) {
    if (result.ec == std::errc{}) {
      at_ = result.ptr;
    } else {
      fail({FrameFault::BufferFull, {}, {}, 0});
    }
    return *this;
  }

  void fail(FrameError error) {
    if (error_) return;
    error_ = error;
    error_->offset = static_cast<std::size_t>(at_ - begin_);
  }

  char* begin_;
  char* at_;
  char* end_;
  std::optional<FrameError> error_;
};

std::optional<std::int64_t> word_of(const SensorFrame& frame) noexcept {
  if (!frame.gain) return std::nullopt;
  return gain_word(*frame.gain, frame.ipoc);
}

}  // namespace

std::string describe(const FrameError& error) {
  std::string field{error.element};
  if (!error.attribute.empty()) field.append(".").append(error.attribute);
  // What a frame does not have at all is nowhere.
  const std::string where = error.offset == 0 ? "" : " (at byte " + std::to_string(error.offset) + ")";
  switch (error.fault) {
    case FrameFault::Malformed:
      return "not a well-formed frame" + where;
    case FrameFault::WrongRoot:
      return "the frame is not of the kind <" + field + "> that is expected here" + where;
    case FrameFault::Missing:
      return field + " is missing" + where;
    case FrameFault::Duplicate:
      return field + " comes twice" + where;
    case FrameFault::BadNumber:
      return field + " is not a number of the right kind" + where;
    case FrameFault::TooMany:
      return field + " has too many attributes" + where;
    case FrameFault::BufferFull:
      return "the frame does not fit into its buffer" + where;
  }
  return "unknown fault" + where;
}

RobotFrame robot_frame(const WireNumbers& numbers) noexcept {
  const auto& six = numbers.six;
  RobotFrame frame;
  frame.ipoc = numbers.ipoc;
  if (six[kRIst]) frame.rist = to_pose(*six[kRIst]);
  if (six[kRSol]) frame.rsol = to_pose(*six[kRSol]);
  frame.aipos_rad = scaled(six[kAIPos], kRadPerDeg);
  frame.aspos_rad = scaled(six[kASPos], kRadPerDeg);
  frame.eipos = six[kEIPos];
  frame.espos = six[kESPos];
  frame.delay = numbers.delay;
  const auto& program = numbers.program;
  frame.program = {.ask = program[0],
                   .state = program[1],
                   .mode = program[2],
                   .override_percent = program[3],
                   .cell = program[4]};
  return frame;
}

std::expected<RobotFrame, FrameError> decode_robot_frame(std::string_view datagram) noexcept {
  FrameReader reader{datagram};
  std::optional<std::uint64_t> ipoc;
  std::array<Found<Axes>, kSixElements.size()> six;
  Found<std::int64_t> delay;
  WireNumbers numbers;
  std::optional<FrameError> program_error;

  bool good = reader.open_root("Rob");
  while (good && reader.next_element()) {
    const std::string_view name = reader.name();
    const auto element = std::ranges::find(kSixElements, name, &SixElement::name);
    const auto place = static_cast<std::size_t>(element - kSixElements.begin());
    if (name == "IPOC") {
      good = reader.read("IPOC", ipoc);
    } else if (name == "Delay") {
      good = reader.read("Delay", "D", delay);
    } else if (name == kProgramElement) {
      good = reader.read(kProgramElement, kProgramNames, numbers.program, program_error);
    } else if (element != kSixElements.end()) {
      good = reader.read(*element, six[place]) && (place != kASPos || reader.needs(six[kASPos]));
    }
  }
  // Beside good commanded axes the actual ones only watch what becomes of the correction.
  if (!reader.error() && !six[kASPos].seen()) reader.needs(six[kAIPos]);
  if (!reader.error() && !ipoc) reader.fail(FrameFault::Missing, "IPOC");
  if (reader.error()) return std::unexpected(*reader.error());

  numbers.ipoc = *ipoc;
  for (std::size_t i = 0; i < six.size(); ++i) numbers.six[i] = six[i].value;
  numbers.delay = delay.value;
  RobotFrame frame = robot_frame(numbers);
  for (const auto* error : {&six[kAIPos].error, &delay.error, &program_error, &six[kRIst].error,
                            &six[kRSol].error, &six[kEIPos].error, &six[kESPos].error}) {
    if (*error && !frame.unread) frame.unread = *error;
  }
  return frame;
}

std::optional<std::uint64_t> readable_ipoc(std::string_view datagram) noexcept {
  constexpr std::string_view kOpen = "<IPOC>", kClose = "</IPOC>";
  const std::size_t open = datagram.find(kOpen);
  if (open == std::string_view::npos || datagram.rfind(kOpen) != open) return std::nullopt;
  const char* const first = datagram.data() + open + kOpen.size();
  const char* const end = datagram.data() + datagram.size();
  std::uint64_t ipoc = 0;
  const auto [rest, error] = std::from_chars(first, end, ipoc);
  if (error != std::errc{} || !std::string_view(rest, end).starts_with(kClose)) return std::nullopt;
  return ipoc;
}

std::expected<std::string_view, FrameError> encode_robot_frame(const RobotFrame& frame,
                                                               std::span<char> buffer,
                                                               int decimals) noexcept {
  FrameWriter writer{buffer};
  writer.text("<Rob Type=\"KUKA\">");
  if (frame.rist) writer.attributes("RIst", kPoseAttributes, to_array(*frame.rist), decimals);
  if (frame.rsol) writer.attributes("RSol", kPoseAttributes, to_array(*frame.rsol), decimals);
  if (frame.aipos_rad)
    writer.attributes("AIPos", kAxisAttributes, scaled(*frame.aipos_rad, kDegPerRad), decimals);
  if (frame.aspos_rad)
    writer.attributes("ASPos", kAxisAttributes, scaled(*frame.aspos_rad, kDegPerRad), decimals);
  if (frame.eipos) writer.attributes("EIPos", kExternalAttributes, *frame.eipos, decimals);
  if (frame.espos) writer.attributes("ESPos", kExternalAttributes, *frame.espos, decimals);
  if (frame.delay) writer.text("<Delay D=\"").integer(*frame.delay).text("\"/>");
  writer.numbers(kProgramElement, kProgramNames,
                 std::array{frame.program.ask, frame.program.state, frame.program.mode,
                            frame.program.override_percent, frame.program.cell});
  writer.text("<IPOC>").integer(frame.ipoc).text("</IPOC></Rob>");
  return writer.result();
}

SensorFrameCodec::SensorFrameCodec(const EthernetConfig& config)
    : sentype_{config.sentype},
      axis_correction_{config.axis_correction.value_or("")},
      stop_{config.stop.value_or("")},
      gain_{config.gain} {
  const auto first = std::ranges::find_if(config.receive, [&](const Element& element) {
    return element.tag == stop_ ||
           (!axis_correction_.empty() && element.tag.starts_with(axis_correction_ + ".A"));
  });
  stop_first_ = first != config.receive.end() && first->tag == stop_;
}

std::expected<std::string_view, FrameError> SensorFrameCodec::encode(const SensorFrame& frame,
                                                                     std::span<char> buffer) const noexcept {
  FrameWriter writer{buffer};
  const auto write_stop = [&] {
    if (frame.stop && !stop_.empty()) {
      writer.text("<").text(stop_).text(*frame.stop ? ">1</" : ">0</").text(stop_).text(">");
    }
  };
  writer.text("<Sen Type=\"").text(sentype_).text("\">");
  if (stop_first_) write_stop();
  if (frame.axis_correction_rad && !axis_correction_.empty()) {
    writer.attributes(axis_correction_, kAxisAttributes, scaled(*frame.axis_correction_rad, kDegPerRad),
                      kSensorDecimals);
  }
  if (!stop_first_) write_stop();
  if (gain_) writer.numbers(kProgramElement, kGainNames, std::array{word_of(frame)});
  writer.text("<IPOC>").integer(frame.ipoc).text("</IPOC></Sen>");
  return writer.result();
}

std::expected<SensorFrame, FrameError> SensorFrameCodec::decode(std::string_view datagram) const noexcept {
  FrameReader reader{datagram};
  std::optional<std::uint64_t> ipoc, stop;
  Found<Axes> correction;
  std::array<std::optional<std::int64_t>, 1> gain;
  std::optional<FrameError> gain_error;

  bool good = reader.open_root("Sen");
  if (good) {
    const bool typed = std::ranges::any_of(reader.attributes(), [this](const xml::Attribute& attribute) {
      return (attribute.name == "Type" || attribute.name == "TYPE") && attribute.value == sentype_;
    });
    good = typed || reader.fail(FrameFault::WrongRoot, "Sen", "Type");
  }
  while (good && reader.next_element()) {
    const std::string_view name = reader.name();
    if (name == "IPOC") {
      good = reader.read("IPOC", ipoc);
    } else if (name == axis_correction_) {
      good = reader.read({axis_correction_, kAxisAttributes}, correction) && reader.needs(correction);
    } else if (name == stop_) {
      good = reader.read(stop_, stop);
      if (good && *stop > 1) good = reader.fail(FrameFault::BadNumber, stop_);
    } else if (gain_ && name == kProgramElement) {
      good = reader.read(kProgramElement, kGainNames, gain, gain_error);
    }
  }
  if (!reader.error() && !ipoc) reader.fail(FrameFault::Missing, "IPOC");
  if (reader.error()) return std::unexpected(*reader.error());

  SensorFrame frame;
  frame.ipoc = *ipoc;
  if (correction.value) frame.axis_correction_rad = scaled(*correction.value, kRadPerDeg);
  if (stop) frame.stop = *stop == 1;
  if (gain[0]) frame.gain = gain_of(*gain[0]);
  return frame;
}

}  // namespace truepose::rsi
