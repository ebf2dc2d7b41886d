#pragma once

#include <cstdint>
#include <expected>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "proto/recording/record.hpp"

namespace truepose::recording {

/// What a device says of itself; empty where it was not asked.
struct Device {
  std::string model, serial, software;
};

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
  std::string date;          ///< UTC, when it was written
  std::int64_t time_ns = 0;  ///< and then on the clock of the records
  std::string reason;        ///< a fault's text
  Device robot, tracker;
  std::string ethernet_xml;                   ///< the RSI configuration in force, as text
  std::string nominal_yaml;                   ///< the nominal arm, as a model file
  std::map<std::string, std::string> stream;  ///< options of the stream: name and number
  std::vector<Model> models;
};

/// How a stream of corrections was told what to do, beside its datagrams.
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

// A recording (version 2; 1 is read as well) is a file of blocks, each with its size and its checksum: the
// header as JSON, blocks of records, and an empty one at its end.

std::string first_block(const Header& header);
std::string block(std::string_view records);
std::string last_block();

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
  std::size_t begin_ = 0;  // of the first block of records
  Header header_;
};

}  // namespace truepose::recording
