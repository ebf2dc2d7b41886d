#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "core/formatted.hpp"
#include "proto/rsi/context.hpp"
#include "proto/rsi/lint_kinds.hpp"

namespace truepose::rsi {
namespace {

/// Of an object, or what holds where there is none or none is given.
double number(const ContextObject* object, std::string_view type, std::string_view parameter) {
  return (object == nullptr ? std::nullopt : object->number(parameter)).value_or(otherwise(type, parameter));
}

/// Looks at one context with one ethernet configuration.
class ContextLint {
 public:
  ContextLint(const Context& context, const EthernetConfig& ethernet, const ContextDemands& demands)
      : context_{context}, ethernet_{ethernet}, demands_{demands} {}

  std::vector<Message> findings() {
    link_ = context_.of_type("ETHERNET");
    if (link_ == nullptr) return {message<LintKind::NoEthernet>()};
    check_link();
    look_for_circles();
    check_correction();
    check_external_axes();
    check_ceiling();
    check_pose_correction();
    check_stop();
    check_program();
    return std::move(findings_);
  }

 private:
  template <LintKind kKind, typename... Values>
  void say(const std::string& place, const Values&... values) {
    Message& found = findings_.emplace_back(message<kKind>(values...));
    if (!place.empty()) found.what = place + ": " + found.what;
  }

  void check_link() {
    const auto file = link_->values.find("ConfigFile");
    if (file == link_->values.end() || file->second != demands_.ethernet_file) {
      say<LintKind::ConfigFile>(link_->id, file == link_->values.end() ? "RSIEthernet.xml" : file->second,
                                demands_.ethernet_file);
    }
    const double precision = number(link_, "ETHERNET", "Precision");
    if (precision < kLeastPrecision)
      say<LintKind::Precision>(link_->id, precision, std::pow(10, -precision), kLeastPrecision);
    const double timeout = number(link_, "ETHERNET", "Timeout");
    if (timeout != demands_.timeout_cycles) {
      say<LintKind::Timeout>(link_->id, timeout, timeout * demands_.cycle_ms / 1000, demands_.timeout_cycles);
    }
  }

  /// The channel of the ETHERNET object on which a RECEIVE element comes out.
  std::optional<int> channel(std::string_view tag, const std::vector<Element>& elements) const {
    const auto found = std::ranges::find(elements, tag, &Element::tag);
    return found == elements.end() ? std::nullopt : found->index;
  }

  /// What an object's output depends on, through any number of objects.
  bool depends_on_link(const ContextObject& object, std::set<std::string>& seen) const {
    if (&object == link_) return true;
    if (!seen.insert(object.id).second) return false;
    return std::ranges::any_of(object.inputs, [&](const auto& wire) {
      return depends_on_link(*context_.with_id(wire.second.object), seen);
    });
  }

  /// RSIVisual and the controller refuse a signal that comes from the PC and goes back to it.
  void look_for_circles() {
    for (const auto& [input, from] : link_->inputs) {
      std::set<std::string> seen;
      if (depends_on_link(*context_.with_id(from.object), seen))
        say<LintKind::Circle>(link_->id, input, from.object, link_->id);
    }
  }

  /// The objects that correct an axis.
  std::vector<const ContextObject*> correcting(int axis) const {
    std::vector<const ContextObject*> objects;
    for (const ContextObject& object : context_.objects) {
      if (object.type == "AXISCORR" && object.inputs.contains(axis)) objects.push_back(&object);
    }
    return objects;
  }

  void check_correction() {
    const ContextObject* const first = context_.of_type("AXISCORR");
    if (first == nullptr) return say<LintKind::NoAxisCorr>("");
    if (!ethernet_.axis_correction) return;
    for (int axis = 1; axis <= 6; ++axis) {
      const std::string name = "A" + std::to_string(axis), tag = *ethernet_.axis_correction + "." + name;
      const std::vector<const ContextObject*> objects = correcting(axis);
      if (objects.empty()) {
        say<LintKind::AxisUnwired>(first->id, name, tag);
      } else if (objects.size() > 1) {
        say<LintKind::AxisTwice>("", objects[0]->id, objects[1]->id, name);
      } else {
        check_axis(*objects[0], axis, name, tag);
      }
    }
  }

  void check_axis(const ContextObject& correction, int axis, const std::string& name,
                  const std::string& tag) {
    const ContextOutput& wire = correction.inputs.at(axis);
    const auto wanted = channel(tag, ethernet_.receive);
    if (!wanted || wire != ContextOutput{link_->id, *wanted}) {
      say<LintKind::AxisWire>(correction.id, name, wire.number, wire.object, tag,
                              wanted ? std::to_string(*wanted) : "none", link_->id);
    }
    const double lower = number(&correction, "AXISCORR", "LowerLim" + name);
    const double upper = number(&correction, "AXISCORR", "UpperLim" + name);
    if (std::min(-lower, upper) < demands_.max_total_deg)
      say<LintKind::Clamp>(correction.id, name, lower, upper, demands_.max_total_deg);
  }

  /// What the daemon sends for an axis of the arm moves no external axis.
  void check_external_axes() {
    for (const ContextObject& object : context_.objects) {
      if (object.type != "AXISCORREXT") continue;
      for (const auto& [input, from] : object.inputs) {
        const std::string source = tag_of(from);
        if (!ethernet_.axis_correction || !source.starts_with(*ethernet_.axis_correction + ".")) continue;
        say<LintKind::ExternalAxis>(object.id, input, source);
      }
    }
  }

  /// The RECEIVE element that comes out of an output of the ETHERNET object; else the object.
  std::string tag_of(const ContextOutput& from) const {
    const auto element = std::ranges::find(ethernet_.receive, std::optional{from.number}, &Element::index);
    return from.object == link_->id && element != ethernet_.receive.end() ? element->tag : from.object;
  }

  void check_ceiling() {
    const ContextObject* const monitor = context_.of_type("AXISCORRMON");
    for (int axis = 1; axis <= 6; ++axis) {
      const std::string name = "A" + std::to_string(axis);
      const double ceiling = number(monitor, "AXISCORRMON", "Max" + name);
      if (ceiling <= demands_.max_total_deg)
        say<LintKind::Ceiling>(monitor == nullptr ? "AXISCORRMON (default)" : monitor->id, name, ceiling,
                               demands_.max_total_deg);
    }
  }

  /// The daemon corrects axes alone: here is only said what this object does.
  void check_pose_correction() {
    const ContextObject* const correction = context_.of_type("POSCORR");
    if (correction == nullptr) return;
    static constexpr std::array<const char*, 5> kSystems{"the world", "the base", "the robot root",
                                                         "the tool", "the direction of the path"};
    const double system = number(correction, "POSCORR", "RefCorrSys");
    std::string along = "a system that is not known";
    for (std::size_t i = 0; i < kSystems.size(); ++i) {
      if (system == static_cast<double>(i)) along = kSystems[i];
    }
    std::string limits;
    for (const std::string axis : {"X", "Y", "Z"}) {
      limits += formatted("%s %g .. %g mm, ", axis.c_str(), number(correction, "POSCORR", "LowerLim" + axis),
                          number(correction, "POSCORR", "UpperLim" + axis));
    }
    limits += formatted("%g deg", number(correction, "POSCORR", "MaxRotAngle"));
    const ContextObject* const monitor = context_.of_type("POSCORRMON");
    say<LintKind::PoseCorrection>(correction->id, along, sources_of(*correction), limits,
                                  number(monitor, "POSCORRMON", "MaxTrans"),
                                  number(monitor, "POSCORRMON", "MaxRotAngle"));
  }

  /// The RECEIVE elements, or objects, that lead to its inputs.
  std::string sources_of(const ContextObject& object) const {
    std::set<std::string> sources;
    for (const auto& [input, from] : object.inputs) {
      const std::string tag = tag_of(from);
      sources.insert(tag.substr(0, tag.find('.')));
    }
    std::string text;
    for (const std::string& source : sources) text += (text.empty() ? "" : " and ") + source;
    return text.empty() ? "no input" : text;
  }

  void check_stop() {
    if (!ethernet_.stop) return;
    const auto wanted = channel(*ethernet_.stop, ethernet_.receive);
    for (const ContextObject& object : context_.objects) {
      if (object.type != "STOP" || !wanted) continue;
      const auto wire = object.inputs.find(1);
      if (wire == object.inputs.end() || wire->second != ContextOutput{link_->id, *wanted}) continue;
      const int leaves = number_of("STOP", "Mode", kExitMoveCorr);
      const double mode = number(&object, "STOP", "Mode");
      if (mode != leaves) say<LintKind::StopMode>(object.id, mode, leaves);
      return;
    }
    say<LintKind::StopMissing>("", *ethernet_.stop);
  }

  /// How a production program and the PC understand each other, where the lists have it.
  void check_program() {
    check_input("Tp.Ask", "SEN_PINT", "$SEN_PINT[1]", Setting{"Index", 1});
    check_input("Tp.Pro", "STATUS", "$PRO_STATE",
                Setting{"Type", number_of("STATUS", "Type", kProgramState)});
    check_input("Tp.Mode", "STATUS", "the operating mode",
                Setting{"Type", number_of("STATUS", "Type", kOperatingMode)});
    check_input("Tp.Ov", "OV_PRO", "$OV_PRO");
    check_input("Tp.Cell", "SEN_PINT", "$SEN_PINT[3]", Setting{"Index", 3});
    const auto wanted = channel(kGainTag, ethernet_.receive);
    if (!ethernet_.gain || !wanted) return;
    for (const ContextObject& object : context_.objects) {
      const auto wire = object.inputs.find(1);
      if (object.type == "MAP2SEN_PINT" && wire != object.inputs.end() &&
          wire->second == ContextOutput{link_->id, *wanted} && number(&object, "MAP2SEN_PINT", "Index") == 2)
        return;
    }
    say<LintKind::Gain>("", kGainTag);
  }

  struct Setting {
    std::string_view parameter;
    int value;
  };

  /// @param with  the setting of an object of this type that selects the signal, where there is a choice
  void check_input(std::string_view tag, std::string_view type, const std::string& what,
                   std::optional<Setting> with = {}) {
    const auto at = channel(tag, ethernet_.send);
    if (!at) return;
    const auto wire = link_->inputs.find(*at);
    const ContextObject* const from =
        wire == link_->inputs.end() ? nullptr : context_.with_id(wire->second.object);
    const auto is_set = [&] { return !with || number(from, type, with->parameter) == with->value; };
    if (from != nullptr && from->type == type && is_set()) return;
    say<LintKind::Input>(link_->id, *at, tag, what);
  }

  const Context& context_;
  const EthernetConfig& ethernet_;
  const ContextDemands& demands_;
  const ContextObject* link_ = nullptr;
  std::vector<Message> findings_;
};

}  // namespace

std::vector<Message> lint(const Context& context, const EthernetConfig& ethernet,
                          const ContextDemands& demands) {
  return ContextLint{context, ethernet, demands}.findings();
}

}  // namespace truepose::rsi
