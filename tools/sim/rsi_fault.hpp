#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace truepose::sim {

/// Something that goes wrong with RSI, in cycles of the simulated controller: the first one of its life is 1.
struct RsiFault {
  enum class Kind {
    LoseBoth,       ///< no datagram gets through, either way
    LoseDatagrams,  ///< none from the controller
    LoseReplies,    ///< none to it
    Duplicate,      ///< the controller's datagrams come twice
    Reorder,        ///< of two datagrams the later one comes first
    Silence,        ///< the controller sends nothing, keeps what is in force, and its clock goes on
    Restart,        ///< RSI is off, and then on with nothing in force, from another port
    IpocJump,       ///< the time stamp jumps
    IgnoreReplies,  ///< corrections move nothing, though their replies are taken
    SecondSender,   ///< a controller of the same kind sends to the same port of the PC
  };
  Kind kind = Kind::LoseBoth;
  std::uint64_t at_cycle = 0;
  std::uint64_t cycles = 0;           ///< how long; 0 = to the end
  std::uint64_t every = 0;            ///< and again after so many; 0 = once
  std::optional<std::uint64_t> ipoc;  ///< Restart: its first time stamp; else the clock has gone on
  std::int64_t ipoc_by = 0;           ///< IpocJump
  std::string from;                   ///< SecondSender: its address; empty = as the first

  bool begins_with(std::uint64_t cycle) const {
    return cycle == at_cycle || (every > 0 && cycle > at_cycle && (cycle - at_cycle) % every == 0);
  }
  bool covers(std::uint64_t cycle) const {
    if (cycle < at_cycle) return false;
    const std::uint64_t since = every > 0 ? (cycle - at_cycle) % every : cycle - at_cycle;
    return cycles == 0 || since < cycles;
  }
};

}  // namespace truepose::sim
