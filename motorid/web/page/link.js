// The socket to the program: frames of samples, and what the program says.

const HEADER = 32; // bytes: lost frames, channels, samples, run; start and period in s
const AGAIN_MS = 1000;
const SILENT_MS = 5000; // the program says something each second: after so long it is not there

export class Link {
  constructor({ status, frame, refused, open, closed }) {
    Object.assign(this, { status, frame, refused, open, closed });
    this.connect();
  }

  connect() {
    const address = new URL("live", location.href);
    address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
    const socket = this.socket = new WebSocket(address);
    let heard = performance.now();
    const over = () => {
      clearInterval(watch);
      socket.onopen = socket.onmessage = socket.onclose = null;
      socket.close();
      this.closed();
      setTimeout(() => this.connect(), AGAIN_MS);
    };
    const watch = setInterval(() => { if (performance.now() - heard > SILENT_MS) over(); }, AGAIN_MS);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => this.open();
    socket.onclose = over;
    socket.onmessage = (event) => {
      heard = performance.now();
      this.#take(event.data);
    };
  }

  ask(what) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(what));
  }

  #take(data) {
    if (typeof data === "string") {
      const said = JSON.parse(data);
      if ("refused" in said) this.refused(said.refused); else this.status(said);
      return;
    }
    const head = new DataView(data);
    const [lost, channels, samples, run] = [0, 4, 8, 12].map((at) => head.getUint32(at, true));
    const columns = [];
    for (let c = 0; c < channels; c++) {
      columns.push(new Float64Array(data, HEADER + 8 * c * samples, samples));
    }
    this.frame({ lost, run, columns, start: head.getFloat64(16, true), period: head.getFloat64(24, true) });
  }
}
