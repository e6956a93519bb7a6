#include "server/access/protection.hpp"

namespace headstock::access {
namespace {

using enum Role;

// 2000TC L7602-7622, L9292-9387: level 2 all, 3 parameters, offsets, programs; 4 offsets, macro variables, programs; 5 panel.
constexpr ProtectionLevel kGsk2000tc[] = {
    {"2", "machine builder", "机床厂家级", "everything, pitch errors, ladder", "全部，螺距补偿，梯形图", administrator, "2000TC L7602"},
    {"3", "manager", "系统管理级", "parameters, offsets, programs", "参数、刀补、程序", setter, "2000TC L7602"},
    {"4", "technologist", "工艺设计级", "offsets, macro variables, programs", "刀补、宏变量、程序", programmer, "2000TC L7602"},
    {"5", "operator", "加工操作级", "the panel only", "仅操作面板", operator_, "2000TC L7602"},
};
// 218T L3465-3512: the password opens the parameter and the program switch; the builder's changes the password.
constexpr ProtectionLevel kGsk218t[] = {
    {"builder", "machine builder", "厂家密码", "the user password", "用户密码", administrator, "218T L3465"},
    {"parameter switch", "parameter switch on", "参数开关", "parameters", "参数", setter, "218T L3465"},
    {"program switch", "program switch on", "程序开关", "programs", "程序", programmer, "218T L3465"},
    {"-", "no password", "无密码", "the panel", "操作面板", operator_, "218T L3465"},
};
// 200T/300T L118-L164: administrator, two programmers, three operators.
constexpr ProtectionLevel kLathe200t[] = {
    {"administrator", "administrator", "管理员", "everything", "全部", administrator, "200T L118"},
    {"programmer", "programmer", "编程员", "programs, more parameters", "程序及更多参数", programmer, "200T L118"},
    {"operator", "operator", "操作员", "moving the machine, some parameters", "操作机床及部分参数", operator_, "200T L118"},
};
// K2000TCi L122: passwords for power-on, parameters and programs; the operation manual with their levels is not at hand.
constexpr ProtectionLevel kK2000[] = {
    {"parameter", "parameter password", "参数密码", "parameters", "参数", setter, "K2000TCi L122"},
    {"program", "program password", "程序密码", "programs", "程序", programmer, "K2000TCi L122"},
    {"power-on", "power-on password", "开机密码", "the panel", "操作面板", operator_, "K2000TCi L122"},
};
// 0i-D 12.3.9, 8-level data protection: 4-7 by password, 0-3 by the key signals; what needs which level is set on the
// control, parameters and pitch errors from level 4 unless it says otherwise.
constexpr ProtectionLevel kFanuc0i[] = {
    {"7", "maintenance", "维修用", "everything", "全部", administrator, "0i-D 12.3.9 L44199"},
    {"6", "machine tool builder", "机床厂", "everything but what is kept for maintenance", "除维修保留项以外的全部", administrator, "0i-D 12.3.9 L44199"},
    {"5", "dealer, integrator", "经销商、集成商", "what the builder left open", "机床厂开放的项目", administrator, "0i-D 12.3.9 L44199"},
    {"4", "end user", "最终用户", "parameters, pitch errors", "参数、螺距误差", setter, "0i-D 12.3.9 L44419"},
    {"1-3", "memory protection keys KEY1-KEY4", "存储保护钥匙 KEY1-KEY4", "offsets, macro variables, programs as set on the control", "按系统设定的刀补、宏变量、程序", programmer, "0i-D 12.3.9 L44199"},
    {"0", "no key", "无钥匙", "the panel", "操作面板", operator_, "0i-D 12.3.9 L44199"},
};

}  // namespace

std::span<const ProtectionLevel> protection_levels(std::string_view profile) {
  struct Entry {
    std::string_view profile;
    std::span<const ProtectionLevel> levels;
  };
  static constexpr Entry table[] = {{"fanuc-0i-t", kFanuc0i}, {"fanuc-0i-m", kFanuc0i}, {"gsk-2000tc", kGsk2000tc},
                                    {"gsk-218t", kGsk218t},   {"k2000tc", kK2000},      {"lathe-200t", kLathe200t}};
  for (const Entry& entry : table)
    if (entry.profile == profile) return entry.levels;
  return {};
}

}  // namespace headstock::access
