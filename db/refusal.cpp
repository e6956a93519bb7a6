#include "db/refusal.hpp"

#include <algorithm>

namespace headstock::db {
namespace {

using enum RefusalKind;

constexpr RefusalText kTexts[] = {
    {"unauthenticated", unauthenticated, "Sign in first.", "请先登录。"},
    {"wrong_sign_in", unauthenticated, "User or password is wrong.", "用户名或密码错误。"},
    {"locked_out", too_many, "Too many wrong passwords. Try again later.", "密码错误次数过多，请稍后再试。"},
    {"must_change_password", forbidden, "Choose your own password first.", "请先设置自己的密码。"},
    {"look_only", forbidden, "This sign-in may only look.", "该登录只能查看。"},
    {"damaged_backup", invalid, "The backup is damaged; nothing was restored.",
     "备份已损坏，未恢复任何内容。"},
    {"not_a_backup", invalid, "This file is no backup of the kind that is wanted here.",
     "该文件不是此处所需的备份。"},
    {"newer_backup", conflict, "The backup was made by a newer Headstock.",
     "该备份由更新版本的 Headstock 制作。"},
    {"backup_running", conflict, "A backup is being made.", "正在备份。"},
    {"provider_failed", unauthenticated, "The sign-in provider could not be used.", "无法使用登录服务。"},
    {"unknown_person", unauthenticated, "Nobody here belongs to this sign-in. Ask an administrator.",
     "此登录未对应任何用户，请联系管理员。"},
    {"in_use", conflict, "Something else still uses this.", "该项仍在被使用。"},
    {"common_password", invalid, "This password is too easy to guess.", "该密码过于简单，容易被猜到。"},
    {"forbidden", forbidden, "Your role may not do this.", "您的权限不允许此操作。"},
    {"weak_password", invalid, "The password is too short, too long, or contains the user name.",
     "密码过短、过长，或包含用户名。"},
    {"last_administrator", conflict, "There must be at least one administrator.", "必须至少保留一名管理员。"},
    {"not_found", not_found, "There is no such thing (any more).", "该项不存在（或已被删除）。"},
    {"name_taken", conflict, "This name is taken.", "该名称已被使用。"},
    {"bad_name", invalid, "This name cannot be used.", "该名称不可用。"},
    {"bad_folder", invalid, "This folder name cannot be used.", "该文件夹名称不可用。"},
    {"bad_role", invalid, "There is no such role.", "没有这种角色。"},
    {"bad_language", invalid, "There is no such language.", "没有这种语言。"},
    {"bad_profile", invalid, "There is no such controller.", "没有这种控制器。"},
    {"bad_machine_file", invalid, "The machine file has a mistake.", "机床文件有错误。"},
    {"bad_value", invalid, "This value cannot be used.", "该数值不可用。"},
    {"in_the_future", invalid, "This time has not come yet.", "该时间尚未到来。"},
    {"shifts_overlap", invalid, "Two shifts overlap.", "班次时间相互重叠。"},
    {"not_empty", conflict, "The folder is not empty.", "文件夹不为空。"},
    {"empty_program", invalid, "The file is empty.", "文件为空。"},
    {"too_large", too_large, "The file is too large.", "文件过大。"},
    {"upload_incomplete", invalid, "The upload was cut off; nothing was kept.", "上传中断，未保存任何内容。"},
    {"released", conflict, "The program is released. Withdraw the release first.",
     "程序已发布，请先撤销发布。"},
    {"not_released", conflict, "This revision is not released.", "该版本尚未发布。"},
    {"not_checked", conflict, "No check of this revision has passed.", "该版本尚未通过检查。"},
    {"check_failed", conflict, "The check found errors.", "检查发现错误。"},
    {"reason_missing", invalid, "Say why.", "请填写原因。"},
    {"no_machines", invalid, "Choose at least one machine.", "请至少选择一台机床。"},
    {"not_connected", conflict, "The machine is not connected.", "机床未连接。"},
    {"machine_refused", conflict, "The machine refused.", "机床拒绝了请求。"},
    {"machine_removed", conflict, "The machine has been removed.", "机床已被删除。"},
    {"drip_open", conflict, "The machine already has a drip-feed.", "该机床已有正在进行的在线传输。"},
    {"transfer_over", conflict, "The transfer is over.", "传输已结束。"},
    {"port_busy", conflict, "Something is under way on this port.", "该端口正在使用中。"},
    {"cannot_queue", conflict, "This control does not ask with DC1, so nothing can wait for it.",
     "该机床不以 DC1 请求，无法排队等待。"},
    {"in_the_past", invalid, "This time has passed.", "该时间已过。"},
    {"not_for_agents", conflict, "A machine with an agent does this at its own panel.",
     "带代理程序的机床请在其面板上进行此操作。"},
    {"place_not_found", conflict, "The program has no such place.", "程序中没有该位置。"},
    {"nothing_under_way", conflict, "Nothing is under way on this port.", "该端口没有正在进行的传输。"},
    {"header_missing", invalid, "A start in the middle needs a header that somebody has read.",
     "从中间开始需要经人工确认的程序头。"},
    {"no_machine", conflict,
     "No machine is named for this port: nobody knows how its control reads the program.",
     "该端口未指定机床，无法得知其系统如何解读程序。"},
    {"no_code", conflict, "The program has a character that the port's tape code lacks.",
     "程序中有该端口代码表没有的字符。"},
    {"numbers_are_used", conflict, "The program refers to its sequence numbers; they cannot be changed.",
     "程序引用了顺序号，不能重新编号。"},
    {"blob_unreadable", unavailable, "The stored file cannot be read.", "存储的文件无法读取。"},
    {"already_decided", conflict, "This has been decided already.", "该项已处理。"},
    {"restart_not_reached", conflict, "The program does not come to this line.", "程序不会执行到该行。"},
    {"restart_alarm", conflict, "The program raises an alarm before this line.", "程序在该行之前产生报警。"},
    {"restart_in_compensation", conflict, "Radius compensation is on at this line. Choose a line outside.",
     "该行处于刀具半径补偿中，请选择补偿以外的行。"},
    {"restart_in_cycle", conflict, "A canned cycle is on at this line. Choose a line outside.",
     "该行处于固定循环中，请选择循环以外的行。"},
    {"restart_mode", conflict, "A mode is on at this line that plain blocks cannot bring back.",
     "该行处于普通程序段无法恢复的模态中。"},
    {"restart_variables", conflict,
     "The program uses variables from this line on; their values would be missing.",
     "该行之后使用了变量，其值将缺失。"},
    {"changed_meanwhile", conflict, "This value has changed meanwhile. Look at it and try again.",
     "该数值已被更改，请查看后重试。"},
    {"value_refused", conflict, "The controller does not take this value.", "系统不接受该数值。"},
    {"same_person", conflict, "A second person has to agree.", "须由另一人确认。"},
    {"no_values", invalid, "There is nothing to change.", "没有需要更改的数值。"},
    {"machine_not_read", conflict, "This machine has never told what it has in its pages.",
     "该机床尚未上报其数据。"},
    {"other_profile", conflict, "This is of a machine with another controller.",
     "这份数据来自另一种控制器的机床。"},
    {"other_unit", conflict, "This file is in another unit.", "该文件的单位不同。"},
    {"bad_sheet", invalid, "This is no table of values.", "无法识别为数据表。"},
    {"tool_life_short", conflict, "The tools left do not last for this run.",
     "剩余刀具寿命不足以完成本次运行。"},
    {"disk_full", unavailable, "The server's disk is full; nothing was changed.",
     "服务器磁盘已满，未作任何更改。"},
    {"damaged_content", unavailable, "The stored file is damaged.", "存储的文件已损坏。"},
    {"cancelled", unavailable, "Cancelled.", "已取消。"},
};

constexpr bool every_code_once() {
  for (std::size_t i = 0; i < std::size(kTexts); ++i)
    for (std::size_t j = i + 1; j < std::size(kTexts); ++j)
      if (kTexts[i].code == kTexts[j].code) return false;
  return true;
}
static_assert(every_code_once(), "a second text for a code would never be read");

}  // namespace

std::span<const RefusalText> refusal_texts() {
  return kTexts;
}

const RefusalText* refusal_text(std::string_view code) {
  const auto* found = std::ranges::find(kTexts, code, &RefusalText::code);
  return found == std::end(kTexts) ? nullptr : found;
}

Refusal::Refusal(std::string code, std::string where)
    : code_(std::move(code)),
      where_(std::move(where)),
      what_(where_.empty() ? code_ : code_ + ": " + where_) {
  const RefusalText* text = refusal_text(code_);
  kind_ = text ? text->kind : RefusalKind::invalid;
}

}  // namespace headstock::db
