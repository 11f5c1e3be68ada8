// The live run: listens to the server, and comes back when the connection is gone. It sends nothing.

const RETRY_MS = [300, 1000, 2000, 5000];

/** Opens the socket; `take` gets every message, `state` gets "open" or "closed". */
export function listen(take, state) {
  let failures = 0;
  const open = () => {
    const socket = new WebSocket(`ws://${location.host}/live`);
    socket.onopen = () => {
      failures = 0;
      state("open");
    };
    socket.onmessage = (event) => {
      if (typeof event.data === "string") take(JSON.parse(event.data));
    };
    socket.onclose = () => {
      state("closed");
      setTimeout(open, RETRY_MS[Math.min(failures++, RETRY_MS.length - 1)]);
    };
  };
  open();
}
