// Serial ports: what each does now, what goes over its line, what came back.
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { list } from "../../api/client";
import { useLoad, useMonotonic } from "../../live/hooks";
import { address, swap, useRoute } from "../../shell/router";
import { useMay } from "../../shell/session";
import { Button, ErrorNote, Tabs } from "../../ui/parts";
import { Census } from "./Census";
import { History } from "./History";
import { MachineData } from "./MachineData";
import { PortForm } from "./PortForm";
import { PortPanel } from "./PortPanel";
import { ReceivedList } from "./ReceivedList";
import type { Plan, Port, Received } from "./types";
import "../../style/dnc.css";

type Tab = "ports" | "received" | "census" | "data" | "history";

export function Dnc() {
  const { t } = useTranslation();
  const route = useRoute();
  const setter = useMay("setter");
  const now = useMonotonic(500);
  const { value: ports, error, reload } = useLoad((signal) => list<Port>("/ports", signal), [Math.floor(now / 500)]);
  const { value: waiting, reload: reloadWaiting } = useLoad((signal) => list<Received>("/received?state=waiting", signal), [Math.floor(now / 2000)]);
  const { value: plans, reload: reloadPlans } = useLoad((signal) => list<Plan>("/port-plans?open=true", signal), [Math.floor(now / 2000)]);
  const [adding, setAdding] = useState(false);
  const [editing, setEditing] = useState<Port | null>(null);
  const tab = (route.search.get("tab") ?? "ports") as Tab;
  const opened = Number(route.search.get("port")) || null;
  return (
    <div className="page" data-page="dnc">
      <div className="page-bar">
        <h1>{t("dnc.title")}</h1>
        {setter && <Button kind="primary" icon="plus" data-action="add-port" onClick={() => setAdding(true)}>{t("dnc.add")}</Button>}
      </div>
      <Tabs<Tab> value={tab} label={t("dnc.title")} onChange={(value) => swap(address(["dnc"], { tab: value }))} options={[
        { value: "ports", text: t("dnc.tab_ports") }, { value: "received", text: t("dnc.tab_received"), ...(waiting?.length ? { count: waiting.length } : {}) },
        { value: "census", text: t("dnc.tab_census") }, { value: "data", text: t("dnc.tab_data") }, { value: "history", text: t("dnc.tab_history") }]} />
      <ErrorNote error={error} />
      {tab === "ports" && (ports?.length === 0 ? <div className="empty">{t("dnc.none")}</div>
        : ports?.map((port) => <PortPanel key={port.id} port={port} plans={plans?.filter((one) => one.port === port.id) ?? []} open={opened === port.id} onEdit={() => setEditing(port)} onChanged={() => { reload(); reloadPlans(); }}
          onOpen={(open) => swap(address(["dnc"], { tab, port: open ? port.id : null }))} />))}
      {tab === "received" && <ReceivedList ports={ports ?? []} onChanged={reloadWaiting} />}
      {tab === "census" && <Census />}
      {tab === "data" && <MachineData ports={ports ?? []} />}
      {tab === "history" && <History ports={ports ?? []} />}
      {(adding || editing) && <PortForm port={editing} onClose={() => { setAdding(false); setEditing(null); reload(); }} />}
    </div>
  );
}
