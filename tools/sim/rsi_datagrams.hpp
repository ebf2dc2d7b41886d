#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "proto/rsi/ethernet_config.hpp"
#include "proto/rsi/frame_codec.hpp"

namespace truepose::sim {

/// What a simulated controller knows of itself in one cycle.
struct RobotValues {
  std::uint64_t ipoc = 0;
  rsi::CartesianPose rist, rsol;
  rsi::Axes aipos_deg{}, aspos_deg{};
  std::int64_t delay = 0;
  rsi::ProgramSignals program{.ask = 1, .state = rsi::kProgramActive};
};

/// Writes the controller's datagrams as one ethernet configuration asks for them: every element of its SEND
/// list in the list's order, IPOC last. Of the ETHERNET object's inputs those are wired that the shipped
/// configuration names (Tp.Ask, Tp.Pro). What the cell does not have (external axes, motor currents,
/// technology parameters, other inputs) is sent as zero, as by a controller that has nothing wired there.
class RobotDatagram {
 public:
  /// @param decimals  the ETHERNET object's Precision
  RobotDatagram(const rsi::EthernetConfig& ethernet, int decimals);

  /// @return valid until the next call
  std::string_view write(const RobotValues& values);

 private:
  enum class Source { Nothing, ZeroNumber, ZeroInteger, RIst, RSol, AIPos, ASPos, Delay, Ask, Program, Ipoc };
  /// Constant text, and a value behind it.
  struct Piece {
    std::string text;
    Source source = Source::Nothing;
    std::size_t index = 0;
  };
  struct Element;

  static std::vector<Element> elements_of(const rsi::EthernetConfig& ethernet);
  void add(const Element& element);
  void append(const Piece& piece, const RobotValues& values);
  void append_number(double value);

  int decimals_;
  std::vector<Piece> pieces_;
  std::string text_;
};

/// Why a controller could not load this SEND list, or the simulated one cannot serve it: one sentence that
/// names the element. Nothing where it can.
std::optional<std::string> unsendable(const rsi::EthernetConfig& ethernet);

/// What the replies of a PC are made of, against the RECEIVE list that a controller has loaded. A real one
/// ignores the rest without a word, and then moves nothing.
class ReplyNames {
 public:
  explicit ReplyNames(const rsi::EthernetConfig& ethernet);

  /// Names in the reply that the list does not have, each told once: "AKorr", "AK.A7".
  std::vector<std::string> new_strangers(std::string_view reply);

 private:
  std::set<std::string, std::less<>> elements_, names_;  // "AK"; "AK.A1" and "Stop"
  std::set<std::string, std::less<>> told_;
};

}  // namespace truepose::sim
