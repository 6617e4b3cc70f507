#include "fsw/commanding/settings.hpp"

#include "fsw/base/text.hpp"

namespace ilp {
namespace {

FixedText<sizeof(SettingRecord::name)> full_name(const ParameterInfo& info) {
  FixedText<sizeof(SettingRecord::name)> name;
  name.add(info.section).add('.').add(info.key);
  return name;
}

}  // namespace

Status load_settings(Reader<SettingRecord> store, MissionParameters& mission) {
  MissionParameters wanted = mission;
  Status ignored;
  SettingRecord setting;
  std::int64_t id = 0;
  Status found = next(store, id, setting);
  for (; found.ok() || found.is(StatusCode::record_damaged); found = next(store, id, setting)) {
    id = found.ok() ? setting.id : found.a;
    if (!found.ok()) {
      ignored = {StatusCode::setting_ignored, id};
      continue;
    }
    if (!set_parameter(wanted, find_parameter(static_cast<std::uint64_t>(setting.id)), setting.value).ok() &&
        ignored.ok()) {
      ignored = {StatusCode::setting_ignored, setting.id};
    }
  }
  if (!found.is(StatusCode::not_found)) return found;
  const Status valid = validate(wanted);
  if (!valid.ok()) return {StatusCode::setting_ignored, 0, valid.a};
  mission = wanted;
  return ignored;
}

Status write_setting(StorePart<Writes<SettingRecord>> store, std::size_t index, double value, TimeNs now) {
  SettingRecord setting;
  setting.id = parameter_info(index).number;
  copy_text(setting.name, full_name(parameter_info(index)).c_str());
  setting.value = value;
  setting.set_ns = now;
  return put(store, setting);
}

}  // namespace ilp
