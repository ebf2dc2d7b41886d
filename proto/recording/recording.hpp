#pragma once

#include <array>
#include <cstdint>
#include <expected>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "proto/record/layout.hpp"
#include "proto/recording/pcapng.hpp"
#include "proto/recording/record.hpp"

namespace truepose::recording {

/// What a device says of itself; empty where it was not asked.
struct Device {
  std::string model, serial, software;
};
void layout(record::Io& io, Device& x);

/// A model that the stream was given.
struct Model {
  std::uint64_t number = 0;  ///< by which Commands name it
  std::string id;            ///< in the store
  std::string sha256;        ///< of its text there
  std::string yaml;          ///< the arm, as a model file; its reflector is the point that is kept
};

/// What a recording is of, and what its replay needs.
struct Header {
  std::string product;  ///< version of truepose
  std::string cell;
  std::string date;                  ///< UTC, when it was written
  std::int64_t time_ns = 0;          ///< and then on the clock of the records
  std::int64_t clock_origin_ns = 0;  ///< UTC of that clock's 0, ns since 1970
  std::string reason;                ///< a fault's text
  Device robot, tracker;
  std::string ethernet_xml;                   ///< the RSI configuration in effect, as text
  std::string nominal_yaml;                   ///< the nominal arm, as a model file
  std::map<std::string, std::string> stream;  ///< options of the stream: name and number
  std::vector<Model> models;
};

/// The commands to a stream of corrections, in addition to its datagrams.
struct Commands {
  enum class Engagement : std::uint8_t { Off, Leaving, On, Armed };
  Engagement engagement = Engagement::Off;
  std::uint64_t acknowledged = 0;  ///< rises with each fault that is acknowledged
  std::uint64_t model = 0;         ///< its number; 0 = none
  std::uint64_t models = 0;        ///< rises with each that it is given, the same again or none included

  bool operator==(const Commands&) const = default;
};
/// "armed 0 2 1"
std::string text(const Commands& commands);
std::expected<Commands, std::string> read_commands(std::string_view text);

// A recording is a pcapng file. RSI, EKI and tracker are interfaces with the packets of UDP and TCP that
// carried their bytes. The interface "daemon" has the header in JSON, and texts "WIRE KIND BYTES" of all
// else.

/// The beginning of a file.
/// @param begin_ns  time of its packets, which the records follow
std::string head(const Header& header, std::int64_t begin_ns);
/// Its end.
std::string tail(const Header& header);

/// Makes packets of records, with the sequence numbers of each TCP connection.
class RecordWriter {
 public:
  /// @param rsi  the address at which the stream listens
  RecordWriter(const Endpoint& rsi, std::int64_t clock_origin_ns)
      : rsi_{rsi}, clock_origin_ns_{clock_origin_ns} {}

  /// Blocks of pcapng; valid until the next call.
  std::string_view blocks(const Record& record);

 private:
  struct Connection {
    Endpoint local, remote;
    std::uint32_t sent = 0, received = 0;  ///< next sequence numbers
  };

  void datagram(const Record& record);
  void connected(const Record& record);
  void segments(const Record& record, Direction direction);
  void segment(const Record& record, Direction direction, std::uint8_t flags, std::string_view payload = {});
  void note(const Record& record);
  void packet(const Record& record, Direction direction, std::string_view bytes);

  Endpoint rsi_;
  std::int64_t clock_origin_ns_;
  std::array<Connection, kWires.size()> connections_;
  std::string blocks_;
};

/// A recording that was read. A file that was cut off, or damaged, is read up to there.
class Recording {
 public:
  /// Error: one sentence on why the file is none.
  static std::expected<Recording, std::string> read(std::string bytes);
  /// The header of a file of which `bytes` are the beginning.
  static std::expected<Header, std::string> read_header(std::string_view bytes);

  const Header& header() const { return header_; }
  /// Each record, in the order in which they were written. @return why the rest cannot be read, one sentence;
  /// empty: all was
  std::string for_each(const std::function<void(const Record& record)>& take) const;

 private:
  std::string bytes_;
  Header header_;
};

}  // namespace truepose::recording
