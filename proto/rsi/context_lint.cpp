#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "core/formatted.hpp"
#include "proto/rsi/context.hpp"

namespace truepose::rsi {
namespace {

constexpr double kLeastPrecision = 4;

/// Of an object, or what holds where there is none or none is given.
double number(const ContextObject* object, std::string_view type, std::string_view parameter) {
  return (object == nullptr ? std::nullopt : object->number(parameter)).value_or(otherwise(type, parameter));
}

/// Looks at one context with one ethernet configuration.
class ContextLint {
 public:
  ContextLint(const Context& context, const EthernetConfig& ethernet, const ContextDemands& demands)
      : context_{context}, ethernet_{ethernet}, demands_{demands} {}

  std::vector<std::string> findings() {
    link_ = context_.of_type("ETHERNET");
    if (link_ == nullptr) return {"the context has no ETHERNET object: nothing is exchanged with the PC"};
    look_at_link();
    look_for_circles();
    look_at_correction();
    look_at_external_axes();
    look_at_ceiling();
    look_at_pose_correction();
    look_at_stop();
    look_at_program();
    return std::move(findings_);
  }

 private:
  void say(std::string sentence) { findings_.push_back(std::move(sentence)); }

  void look_at_link() {
    const auto file = link_->values.find("ConfigFile");
    if (file == link_->values.end() || file->second != demands_.ethernet_file) {
      say(link_->id + " loads " + (file == link_->values.end() ? "RSIEthernet.xml" : file->second) +
          ", not " + demands_.ethernet_file + ": give its ConfigFile that name");
    }
    const double precision = number(link_, "ETHERNET", "Precision");
    if (precision < kLeastPrecision) {
      say(link_->id + ": Precision " + formatted("%g", precision) + " rounds the axes to " +
          formatted("%g", std::pow(10, -precision)) + " deg: set it to 4");
    }
    const double timeout = number(link_, "ETHERNET", "Timeout");
    if (timeout != demands_.timeout_cycles) {
      say(link_->id + ": Timeout is " + formatted("%g", timeout) + " cycles (" +
          formatted("%g", timeout * demands_.cycle_ms / 1000) + " s), but stream.timeout_cycles is " +
          std::to_string(demands_.timeout_cycles) + ": they must be the same");
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
      if (!depends_on_link(*context_.with_id(from.object), seen)) continue;
      say(link_->id + ": input " + std::to_string(input) + " comes from " + from.object + ", which " +
          link_->id +
          " itself leads: the controller refuses such a circle (\"Circular "
          "linking\"). Take the wire out");
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

  void look_at_correction() {
    const ContextObject* const first = context_.of_type("AXISCORR");
    if (first == nullptr) return say("the context has no AXISCORR object: no correction reaches an axis");
    if (!ethernet_.axis_correction) return;
    for (int axis = 1; axis <= 6; ++axis) {
      const std::string name = "A" + std::to_string(axis), tag = *ethernet_.axis_correction + "." + name;
      const std::vector<const ContextObject*> objects = correcting(axis);
      if (objects.empty()) {
        say(first->id + ": nothing leads to Corr" + name + ", which " + tag + " is to move");
      } else if (objects.size() > 1) {
        say(objects[0]->id + " and " + objects[1]->id + " both correct " + name +
            ": the corrections may add up. Leave one of them");
      } else {
        look_at_axis(*objects[0], axis, name, tag);
      }
    }
  }

  void look_at_axis(const ContextObject& correction, int axis, const std::string& name,
                    const std::string& tag) {
    const ContextOutput& wire = correction.inputs.at(axis);
    const auto wanted = channel(tag, ethernet_.receive);
    if (!wanted || wire != ContextOutput{link_->id, *wanted}) {
      say(correction.id + ": Corr" + name + " is led by output " + std::to_string(wire.number) + " of " +
          wire.object + ", but " + tag + " comes out of output " +
          (wanted ? std::to_string(*wanted) : "none") + " of " + link_->id);
    }
    const double lower = number(&correction, "AXISCORR", "LowerLim" + name);
    const double upper = number(&correction, "AXISCORR", "UpperLim" + name);
    if (std::min(-lower, upper) < demands_.max_total_deg) {
      say(correction.id + " clamps " + name + " without a word to " + formatted("%g", lower) + " .. " +
          formatted("%g", upper) + " deg, and up to " + formatted("%g", demands_.max_total_deg) +
          " deg are sent: widen it, or lower stream.max_total_deg");
    }
  }

  /// What the daemon sends for an axis of the arm moves no external axis.
  void look_at_external_axes() {
    for (const ContextObject& object : context_.objects) {
      if (object.type != "AXISCORREXT") continue;
      for (const auto& [input, from] : object.inputs) {
        const std::string source = tag_of(from);
        if (!ethernet_.axis_correction || !source.starts_with(*ethernet_.axis_correction + ".")) continue;
        say(object.id + ": CorrE" + std::to_string(input) + " is led by " + source +
            ", which is to move an axis of the arm alone. Take the wire out");
      }
    }
  }

  /// The RECEIVE element that comes out of an output of the ETHERNET object; else the object.
  std::string tag_of(const ContextOutput& from) const {
    const auto element = std::ranges::find(ethernet_.receive, std::optional{from.number}, &Element::index);
    return from.object == link_->id && element != ethernet_.receive.end() ? element->tag : from.object;
  }

  void look_at_ceiling() {
    const ContextObject* const monitor = context_.of_type("AXISCORRMON");
    for (int axis = 1; axis <= 6; ++axis) {
      const std::string name = "A" + std::to_string(axis);
      const double ceiling = number(monitor, "AXISCORRMON", "Max" + name);
      if (ceiling > demands_.max_total_deg) continue;
      say((monitor == nullptr ? "AXISCORRMON, which is always there," : monitor->id) + " stops RSI at " +
          formatted("%g", ceiling) + " deg of " + name + ", and up to " +
          formatted("%g", demands_.max_total_deg) + " deg are sent: set it above");
    }
  }

  /// The daemon corrects axes alone: here is only said what this object does.
  void look_at_pose_correction() {
    const ContextObject* const correction = context_.of_type("POSCORR");
    if (correction == nullptr) return;
    static constexpr std::array<const char*, 5> kSystems{"the world", "the base", "the robot root",
                                                         "the tool", "the direction of the path"};
    const double system = number(correction, "POSCORR", "RefCorrSys");
    std::string along = "a system that is not known";
    for (std::size_t i = 0; i < kSystems.size(); ++i) {
      if (system == static_cast<double>(i)) along = kSystems[i];
    }
    const auto text = [](const ContextObject* object, std::string_view type, const std::string& name) {
      return formatted("%g", number(object, type, name));
    };
    std::string limits;
    for (const char axis : {'X', 'Y', 'Z'})
      limits += std::string{axis} + " " + text(correction, "POSCORR", std::string{"LowerLim"} + axis) +
                " .. " + text(correction, "POSCORR", std::string{"UpperLim"} + axis) + " mm, ";
    const ContextObject* const monitor = context_.of_type("POSCORRMON");
    say(correction->id + " moves the TCP along " + along + " by what " + sources_of(*correction) +
        " brings (" + limits + text(correction, "POSCORR", "MaxRotAngle") + " deg; POSCORRMON stops RSI at " +
        text(monitor, "POSCORRMON", "MaxTrans") + " mm or " + text(monitor, "POSCORRMON", "MaxRotAngle") +
        " deg): the daemon corrects axes alone (AXISCORR) and sends nothing for it");
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

  void look_at_stop() {
    if (!ethernet_.stop) return;
    const auto wanted = channel(*ethernet_.stop, ethernet_.receive);
    for (const ContextObject& object : context_.objects) {
      if (object.type != "STOP" || !wanted) continue;
      const auto wire = object.inputs.find(1);
      if (wire == object.inputs.end() || wire->second != ContextOutput{link_->id, *wanted}) continue;
      const int leaves = number_of("STOP", "Mode", kExitMoveCorr);
      if (number(&object, "STOP", "Mode") != leaves) {
        say(object.id + ": Mode must be " + std::to_string(leaves) +
            " (ExitMoveCorr): the Stop bit then leaves RSI_MOVECORR and does "
            "nothing else");
      }
      return;
    }
    say("no STOP object is led by " + *ethernet_.stop + ": the PC cannot leave RSI_MOVECORR");
  }

  /// How a production program and the PC understand each other, where the lists have it.
  void look_at_program() {
    look_at_input("Tp.Ask", "SEN_PINT", "$SEN_PINT[1]", Setting{"Index", 1});
    look_at_input("Tp.Pro", "STATUS", "$PRO_STATE",
                  Setting{"Type", number_of("STATUS", "Type", kProgramState)});
    look_at_input("Tp.Mode", "STATUS", "the operating mode",
                  Setting{"Type", number_of("STATUS", "Type", kOperatingMode)});
    look_at_input("Tp.Ov", "OV_PRO", "$OV_PRO");
    look_at_input("Tp.Cell", "SEN_PINT", "$SEN_PINT[3]", Setting{"Index", 3});
    const auto wanted = channel(kGainTag, ethernet_.receive);
    if (!ethernet_.gain || !wanted) return;
    for (const ContextObject& object : context_.objects) {
      const auto wire = object.inputs.find(1);
      if (object.type == "MAP2SEN_PINT" && wire != object.inputs.end() &&
          wire->second == ContextOutput{link_->id, *wanted} && number(&object, "MAP2SEN_PINT", "Index") == 2)
        return;
    }
    say("no MAP2SEN_PINT object writes " + std::string{kGainTag} +
        " to $SEN_PINT[2]: TP_BEGIN() would wait for ever");
  }

  struct Setting {
    std::string_view parameter;
    int value;
  };

  /// @param with  how an object of this type is told what to send, where there is a choice
  void look_at_input(std::string_view tag, std::string_view type, const std::string& what,
                     std::optional<Setting> with = {}) {
    const auto at = channel(tag, ethernet_.send);
    if (!at) return;
    const auto wire = link_->inputs.find(*at);
    const ContextObject* const from =
        wire == link_->inputs.end() ? nullptr : context_.with_id(wire->second.object);
    const auto is_set = [&] { return !with || number(from, type, with->parameter) == with->value; };
    if (from != nullptr && from->type == type && is_set()) return;
    say(link_->id + ": input " + std::to_string(*at) + ", sent as " + std::string{tag} + ", is not led by " +
        what);
  }

  const Context& context_;
  const EthernetConfig& ethernet_;
  const ContextDemands& demands_;
  const ContextObject* link_ = nullptr;
  std::vector<std::string> findings_;
};

}  // namespace

std::vector<std::string> lint(const Context& context, const EthernetConfig& ethernet,
                              const ContextDemands& demands) {
  return ContextLint{context, ethernet, demands}.findings();
}

}  // namespace truepose::rsi
