#pragma once

#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "proto/rpc/method.hpp"

namespace truepose::rpc {

struct JobError {
  int code = 0;
  std::string message{};
  boost::json::object data{};
};

struct Job {
  std::string id{};
  std::string method{};
  std::string state{};
  std::string doing{};
  std::string started{};
  std::optional<std::string> ended{};
  std::optional<boost::json::value> result{};
  std::optional<JobError> error{};
};
void layout(Io& io, Job& x);

/// What every method of the cell takes besides its own parameters.
struct AsJob {
  bool job = false;
};
void layout(Io& io, AsJob& x);
/// What a call as a job is answered with at once.
struct JobBegun {
  std::string job{};
};
void layout(Io& io, JobBegun& x);

/// The notification `greeting`
struct Greeting {
  struct Protocol {
    int major = 0;
    int minor = 0;
  };
  std::string product{};
  std::string version{};
  Protocol protocol{};
  std::string cell{};
  std::string time{};
  std::vector<std::string> auth{};
};
void layout(Io& io, Greeting& x);

/// session.challenge
struct SessionChallenge : NoParameters {
  struct Result {
    std::string nonce{};
  };
  static const Method& method();
};
void layout(Io& io, SessionChallenge::Result& x);

/// session.hello
struct SessionHello {
  struct Result {
    std::string product{};
    std::string version{};
    int protocol = 0;
    std::string cell{};
    std::string name{};
    control::Role role{};
    std::string time{};
    std::uint64_t next_seq = 0;
    std::optional<std::string> proof{};
  };
  static const Method& method();

  int protocol = 0;
  std::optional<std::string> token{};
  std::optional<std::string> nonce{};
  std::optional<std::string> proof{};
  std::optional<std::chrono::seconds> heartbeat_s{};
};
void layout(Io& io, SessionHello& x);
void check(const Io& io, const SessionHello& x);
void layout(Io& io, SessionHello::Result& x);

/// session.ping
struct SessionPing : NoParameters {
  struct Result {
    std::string time{};
    std::uint64_t next_seq = 0;
  };
  static const Method& method();
};
void layout(Io& io, SessionPing::Result& x);

struct TlsCertificate {
  std::string fingerprint{};
  std::string valid_until{};
};

/// system.info
struct SystemInfo : NoParameters {
  struct Result {
    std::string product{};
    std::string version{};
    std::uint64_t protocol = 0;
    std::string cell{};
    std::string time{};
    std::string started{};
    double uptime_s = 0;
    std::uint64_t connections = 0;
    std::optional<TlsCertificate> tls{};
  };
  static const Method& method();
};
void layout(Io& io, SystemInfo::Result& x);

/// job.get
struct JobGet {
  using Result = Job;
  static const Method& method();

  std::string id{};
};
void layout(Io& io, JobGet& x);

/// rpc.discover: a method of OpenRPC itself, which openrpc.json does not list
struct Discover {
  using Result = boost::json::value;
  static const Method& method();

  std::optional<std::string> of_method{};
};
void layout(Io& io, Discover& x);

/// The methods of this file, without rpc.discover.
std::vector<Described> session_methods();

}  // namespace truepose::rpc
