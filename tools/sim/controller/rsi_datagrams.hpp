#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/rsi/ethernet_config.hpp"
#include "proto/rsi/frame_codec.hpp"
#include "tools/sim/controller/rsi_flow.hpp"

namespace truepose::sim {

/// What a simulated controller knows of itself in one cycle.
struct RobotValues {
  std::uint64_t ipoc = 0;
  rsi::CartesianPose rist, rsol;
  rsi::Axes aipos_deg{}, aspos_deg{};
  std::int64_t delay = 0;
  ChannelValues inputs;  ///< of the ETHERNET object
};

/// Writes the controller's datagrams as one ethernet configuration asks for them: every element of its SEND
/// list in the list's order, IPOC last. What the cell does not have (external axes, motor currents,
/// technology parameters, inputs without a wire) is sent as zero, as by a controller that has nothing wired
/// there.
class RobotDatagram {
 public:
  /// @param decimals  the ETHERNET object's Precision
  RobotDatagram(const rsi::EthernetConfig& ethernet, int decimals);

  /// @return valid until the next call
  std::string_view write(const RobotValues& values);

 private:
  enum class Source { Nothing, ZeroNumber, RIst, RSol, AIPos, ASPos, Delay, Input, InputInteger, Ipoc };
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

/// Why a controller drops a whole reply, which it reports nowhere.
struct ReplyFault {
  enum class Cause { NoXml, Sentype, NoIpoc, NoNumber, OtherIpoc, AnsweredBefore };
  Cause cause = Cause::NoXml;
  std::string text{};  ///< with the value, what is expected, and what to do
};

/// Reads the replies of a PC as the ETHERNET object does: by SENTYPE and IPOC, and the values of the RECEIVE
/// list. It ignores all else in them silently, and then moves nothing; this class reports it.
class ReplyReader {
 public:
  explicit ReplyReader(rsi::EthernetConfig ethernet);

  struct Reply {
    std::uint64_t ipoc = 0;
    ChannelValues outputs;  ///< those that it has
  };
  std::expected<Reply, ReplyFault> read(std::string_view datagram);

  /// Names in the replies that the list does not have, each returned once: "AKorr", "AK.A7".
  std::vector<std::string> take_unknown_names() { return std::exchange(unknown_names_, {}); }

 private:
  void tell(std::string name);

  rsi::EthernetConfig ethernet_;
  std::set<std::string, std::less<>> elements_, names_;  // "AK"; "AK.A1" and "Stop"
  std::set<std::string, std::less<>> returned_names_;
  std::vector<std::string> unknown_names_;
};

}  // namespace truepose::sim
