// What an administrator keeps the shop with: people, what they may do, screens, the audit trail, backups, messages.
import { useTranslation } from "react-i18next";
import { address, swap, useRoute } from "../../shell/router";
import { Tabs } from "../../ui/parts";
import { Users } from "../Users";
import { Audit } from "./Audit";
import { Backups } from "./Backups";
import { Messages } from "./Messages";
import { Rights } from "./Rights";
import { Screens } from "./Screens";

const tabs = ["people", "rights", "screens", "audit", "backups", "messages"] as const;
type Tab = (typeof tabs)[number];

export function Admin() {
  const { t } = useTranslation();
  const route = useRoute();
  const wanted = route.search.get("tab") as Tab | null;
  const tab: Tab = wanted && tabs.includes(wanted) ? wanted : "people";
  return (
    <div className="page" data-page="admin">
      <Tabs label={t("admin.title")} value={tab} onChange={(value) => swap(address(["users"], { tab: value === "people" ? null : value }))}
        options={tabs.map((value) => ({ value, text: t(`admin.tab_${value}`) }))} />
      {tab === "people" && <Users />}
      {tab === "rights" && <Rights />}
      {tab === "screens" && <Screens />}
      {tab === "audit" && <Audit />}
      {tab === "backups" && <Backups />}
      {tab === "messages" && <Messages />}
    </div>
  );
}
