#include "db/refusal.hpp"

#include <algorithm>

namespace headstock::db {
namespace {

using enum RefusalKind;

constexpr RefusalText kTexts[] = {
    {"unauthenticated", unauthenticated, "Sign in first.", "请先登录。"},
    {"wrong_sign_in", unauthenticated, "User or password is wrong.", "用户名或密码错误。"},
    {"locked_out", too_many, "Too many wrong passwords. Try again later.", "密码错误次数过多，请稍后再试。"},
    {"forbidden", forbidden, "Your role may not do this.", "您的权限不允许此操作。"},
    {"weak_password", invalid, "The password must have 8 to 1000 characters and differ from the user name.",
     "密码须为 8 至 1000 个字符，且不能与用户名相同。"},
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
    {"disk_full", unavailable, "The server's disk is full; nothing was changed.",
     "服务器磁盘已满，未作任何更改。"},
    {"damaged_content", unavailable, "The stored file is damaged.", "存储的文件已损坏。"},
    {"cancelled", unavailable, "Cancelled.", "已取消。"},
};

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
