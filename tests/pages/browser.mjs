// Chromium without a window, driven over the pipe of its DevTools protocol: messages are JSON
// with a zero byte behind each. No package is needed.

import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const COMMANDS = ['chromium', 'chromium-browser', 'google-chrome'];

/** Start a browser; the command is the first of those that are installed. */
export async function launch() {
  for (const command of COMMANDS) {
    const browser = await start(command);
    if (browser) return browser;
  }
  return null;
}

async function start(command) {
  const profile = mkdtempSync(join(tmpdir(), 'pages-'));
  const child = spawn(command, [
    '--headless=new', '--no-sandbox', '--disable-gpu', '--hide-scrollbars', '--no-first-run',
    '--disable-background-networking', '--disable-component-update', '--disable-sync',
    '--font-render-hinting=none', '--remote-debugging-pipe', `--user-data-dir=${profile}`,
    'about:blank',
  ], { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'] });
  const missing = new Promise((resolve) => child.on('error', () => resolve(null)));
  const waiting = new Map();
  const listeners = [];
  let last = 0, buffer = '';
  child.stdio[4].setEncoding('utf8');
  child.stdio[4].on('data', (text) => {
    buffer += text;
    const messages = buffer.split('\0');
    buffer = messages.pop();
    for (const message of messages.map((one) => JSON.parse(one))) {
      const own = waiting.get(message.id);
      waiting.delete(message.id);
      if (own && message.error) own.reject(new Error(`${own.method}: ${message.error.message}`));
      else if (own) own.resolve(message.result);
      else listeners.forEach((listen) => listen(message));
    }
  });
  child.stdio[3].on('error', () => {});
  const send = (method, params = {}, sessionId = undefined) =>
    new Promise((resolve, reject) => {
      waiting.set(++last, { resolve, reject, method });
      child.stdio[3].write(`${JSON.stringify({ id: last, method, params, sessionId })}\0`);
    });
  const version = await Promise.race([missing, send('Browser.getVersion')]);
  if (!version) return null;
  return {
    version: version.product,
    page: () => page(send, listeners),
    async close() {
      await send('Browser.close').catch(() => {});
      await new Promise((resolve) => (child.exitCode === null ? child.on('exit', resolve) : resolve()));
      rmSync(profile, { recursive: true, force: true, maxRetries: 5 });
    },
  };
}

/** A tab: its protocol, what went wrong in it, and what it asked of the network. */
async function page(send, listeners) {
  const { targetId } = await send('Target.createTarget', { url: 'about:blank' });
  const { sessionId } = await send('Target.attachToTarget', { targetId, flatten: true });
  const tell = (method, params) => send(method, params, sessionId);
  const complaints = [], requests = [];
  let loaded = () => {};
  listeners.push(({ method, params, sessionId: of }) => {
    if (of !== sessionId) return;
    if (method === 'Runtime.exceptionThrown') {
      const { text, exception } = params.exceptionDetails;
      complaints.push(`${text} ${exception?.description ?? ''}`);
    }
    if (method === 'Runtime.consoleAPICalled' && ['error', 'warning', 'assert'].includes(params.type)) {
      complaints.push(params.args.map((arg) => arg.value ?? arg.description).join(' '));
    }
    if (method === 'Log.entryAdded') complaints.push(params.entry.text);
    if (method === 'Network.requestWillBeSent') requests.push(params.request.url);
    if (method === 'Page.loadEventFired') loaded();
  });
  for (const domain of ['Page', 'Runtime', 'Log', 'Network', 'DOM']) await tell(`${domain}.enable`);
  const evaluate = async (expression) => {
    const asked = { expression, returnByValue: true, awaitPromise: true };
    const { result, exceptionDetails } = await tell('Runtime.evaluate', asked);
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result.value;
  };
  return {
    tell,
    complaints,
    requests,
    evaluate,
    /** The value of a function of the page. */
    ask: (of, ...given) => evaluate(`(${of})(${given.map((x) => JSON.stringify(x)).join(', ')})`),
    async open(url) {
      const done = new Promise((resolve) => { loaded = resolve; });
      await tell('Page.navigate', { url });
      await done;
    },
    size: (width, height, scale = 1) =>
      tell('Emulation.setDeviceMetricsOverride', { width, height, deviceScaleFactor: scale, mobile: width < 500 }),
    media: (media, scheme) =>
      tell('Emulation.setEmulatedMedia', { media, features: [{ name: 'prefers-color-scheme', value: scheme }] }),
    async point(x, y) {
      await tell('Input.dispatchMouseEvent', { type: 'mouseMoved', x, y });
    },
    async press(key, code) {
      for (const type of ['keyDown', 'keyUp']) {
        await tell('Input.dispatchKeyEvent', { type, key, code: key, windowsVirtualKeyCode: code });
      }
    },
    async picture(clip) {
      const shot = await tell('Page.captureScreenshot', { format: 'png', clip, captureBeyondViewport: Boolean(clip) });
      return Buffer.from(shot.data, 'base64');
    },
    close: () => send('Target.closeTarget', { targetId }),
  };
}
